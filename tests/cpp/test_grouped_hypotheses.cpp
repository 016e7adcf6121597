// Objects on a table by all cues at once, on ray-cast scenes.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "graspctx/segmentation.hpp"
#include "overlap.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;
using testing::overlap;

// They touch, and one hides a little of the other.
const Box left{{-0.045, -0.01, 0.03}, {0.04, 0.03, 0.03}, 0.3, {60, 90, 200}};
const Box right{{0.04, 0.025, 0.05}, {0.03, 0.03, 0.05}, 0.8, {180, 120, 40}};

Segmentation segment(const CastScene& scene, const SegmentationOptions& options = {}) {
  return segment_objects(scene.pair, compute_disparity(scene.pair), testing::test_camera(), options);
}

TEST(GroupedHypotheses, TouchingObjectsAreTwo) {
  const CastScene scene = testing::cast_scene(testing::test_camera(), {left, right});
  const Segmentation found = segment(scene);
  ASSERT_EQ(found.objects.size(), 2u);
  EXPECT_GT(overlap(scene.instance_ids == 1, found), 0.85);
  EXPECT_GT(overlap(scene.instance_ids == 2, found), 0.85);
}

TEST(GroupedHypotheses, AreTheSameTwice) {
  const CastScene scene = testing::cast_scene(testing::test_camera(), {left, right});
  const cv::Mat once = segment(scene).instance_ids, again = segment(scene).instance_ids;
  EXPECT_EQ(cv::countNonZero(once != again), 0);
}

TEST(GroupedHypotheses, DoNotDependOnTheImagesSize) {
  // Twice as large, the regions are found on a smaller picture.
  StereoCamera large = testing::test_camera();
  large.focal_px *= 2;
  large.centre_px = 2 * large.centre_px + Eigen::Vector2d(0.5, 0.5);
  large.width_px *= 2;
  large.height_px *= 2;
  const CastScene scene = testing::cast_scene(large, {left, right});
  const Segmentation found =
      segment_objects(scene.pair, compute_disparity(scene.pair), large, SegmentationOptions{});
  EXPECT_GT(overlap(scene.instance_ids == 1, found), 0.85);
  EXPECT_GT(overlap(scene.instance_ids == 2, found), 0.85);
}

}  // namespace
}  // namespace graspctx
