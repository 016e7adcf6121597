// Scenes without a support plane: objects told by the steps in depth around them.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "graspctx/segmentation.hpp"
#include "overlap.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;
using testing::iou;
using testing::overlap;

constexpr CueLevel levels[] = {CueLevel::disparity, CueLevel::plane, CueLevel::colour};

/// The camera looks straight at a wall, the plane z = 0; the image's down is −y.
Eigen::Isometry3d look_at_wall(double turned_rad = 0) {
  return Eigen::AngleAxisd(turned_rad, Eigen::Vector3d::UnitY()) *
         testing::look_at_table(1.2, CV_PI / 2 - 1e-3, 0);
}

const Box near_box{{-0.14, 0.05, 0.4}, {0.06, 0.08, 0.05}, 0, {60, 90, 200}};
const Box far_box{{0.16, -0.04, 0.25}, {0.07, 0.05, 0.05}, 0, {190, 120, 60}};

const CastScene& two_floating_boxes() {
  static const CastScene scene =
      testing::cast_scene(testing::test_camera(), {near_box, far_box}, look_at_wall());
  return scene;
}

Segmentation segment(const RectifiedPair& pair, const SegmentationOptions& options,
                     const StereoCamera& camera = testing::test_camera()) {
  return segment_objects(pair, compute_disparity(pair), camera, options);
}

Segmentation segment(const RectifiedPair& pair, CueLevel cues) {
  SegmentationOptions options;
  options.cues = cues;
  return segment(pair, options);
}

TEST(NoPlane, BoxesBeforeAFarWallAreFoundAndNothingElse) {
  const CastScene& scene = two_floating_boxes();
  for (const CueLevel cues : levels) {
    const Segmentation found = segment(scene.pair, cues);
    EXPECT_FALSE(found.table);
    ASSERT_EQ(found.objects.size(), 2u);
    for (int id = 1; id <= 2; ++id) EXPECT_GT(overlap(scene.instance_ids == id, found), 0.8);
    // 12 x 16 cm at 0.75 m come before 14 x 10 cm at 0.9 m.
    EXPECT_GT(found.objects[0].saliency, found.objects[1].saliency);
    EXPECT_GT(iou(scene.instance_ids == 1, found.instance_ids == found.objects[0].id), 0.8);
  }
}

TEST(NoPlane, WallsAndWhatIsTooLargeAreNoObjects) {
  const Box half_a_wall{{-1.0, 0, 0.3}, {1.0, 2.0, 0.1}, 0, {90, 120, 120}};
  const Box shelf{{0, -0.1, 0.3}, {2.0, 0.02, 0.05}, 0, {90, 120, 120}};
  const std::vector<std::pair<std::string, CastScene>> cases{
      {"a wall", testing::cast_scene(testing::test_camera(), {}, look_at_wall())},
      {"a slanting wall", testing::cast_scene(testing::test_camera(), {}, look_at_wall(0.5))},
      {"a wall before a wall", testing::cast_scene(testing::test_camera(), {half_a_wall}, look_at_wall())},
      {"a shelf", testing::cast_scene(testing::test_camera(), {shelf}, look_at_wall())}};
  for (const auto& [name, scene] : cases) {
    for (const CueLevel cues : levels) EXPECT_TRUE(segment(scene.pair, cues).objects.empty()) << name;
  }
  const CastScene table = testing::cast_scene(testing::test_camera(), {});
  EXPECT_TRUE(segment(table.pair, CueLevel::disparity).objects.empty());
}

TEST(NoPlane, OnAnArmTheDisparityTakesTheArmAlongAndTheColourDoesNot) {
  // As in the Adirondack pair: a cup on the arm of a chair, both far from the wall.
  const Box cup{{0.02, 0.05, 0.4}, {0.04, 0.05, 0.04}, 0, {50, 160, 200}};
  const Box arm{{0.0, -0.02, 0.4}, {0.19, 0.02, 0.05}, 0, {110, 110, 90}};
  const CastScene scene = testing::cast_scene(testing::test_camera(), {cup, arm}, look_at_wall());
  const cv::Mat truth = scene.instance_ids == 1, on_arm = scene.instance_ids == 2;
  const cv::Moments m = cv::moments(truth, true);
  SegmentationOptions options;
  options.fixation_px = Eigen::Vector2d(m.m10 / m.m00, m.m01 / m.m00);
  options.cues = CueLevel::disparity;
  const Segmentation rough = segment(scene.pair, options);
  options.cues = CueLevel::colour;
  const Segmentation fine = segment(scene.pair, options);
  ASSERT_EQ(rough.objects.size(), 1u);
  ASSERT_EQ(fine.objects.size(), 1u);
  EXPECT_GT(cv::countNonZero(rough.instance_ids & on_arm), 0.2 * cv::countNonZero(truth));
  EXPECT_GT(cv::countNonZero(rough.instance_ids & truth), 0.9 * cv::countNonZero(truth));
  EXPECT_GT(overlap(truth, fine), 0.85);
  EXPECT_GT(overlap(truth, fine), overlap(truth, rough) + 0.1);

  // The box around the cup does the same without a gaze, and cuts the arm off at every level.
  options.fixation_px.reset();
  options.roi_px = cv::boundingRect(truth);
  for (const CueLevel cues : levels) {
    options.cues = cues;
    EXPECT_GT(overlap(truth, segment(scene.pair, options)), 0.85);
  }
}

TEST(NoPlane, AFixationOrABoxPicksOne) {
  const CastScene& scene = two_floating_boxes();
  for (int id = 1; id <= 2; ++id) {
    const cv::Mat truth = scene.instance_ids == id;
    const cv::Rect around = cv::boundingRect(truth);
    for (const CueLevel cues : levels) {
      SegmentationOptions options;
      options.cues = cues;
      options.fixation_px = Eigen::Vector2d(around.x + 0.7 * around.width, around.y + 0.3 * around.height);
      const Segmentation looked_at = segment(scene.pair, options);
      ASSERT_EQ(looked_at.objects.size(), 1u);
      EXPECT_GT(overlap(truth, looked_at), 0.8);
      options.fixation_px.reset();
      options.roi_px = cv::Rect(around.x - 20, around.y - 20, around.width + 40, around.height + 40);
      const Segmentation boxed = segment(scene.pair, options);
      ASSERT_EQ(boxed.objects.size(), 1u);
      EXPECT_GT(overlap(truth, boxed), 0.8);
    }
  }
  for (const CueLevel cues : levels) {
    SegmentationOptions options;
    options.cues = cues;
    options.roi_px = cv::Rect(400, 20, 200, 100);  // bare wall
    EXPECT_TRUE(segment(scene.pair, options).objects.empty());
  }
}

TEST(NoPlane, TheSameForImagesOfTwiceTheSize) {
  const CastScene& scene = two_floating_boxes();
  RectifiedPair large;
  cv::resize(scene.pair.left, large.left, {}, 2, 2, cv::INTER_CUBIC);
  cv::resize(scene.pair.right, large.right, {}, 2, 2, cv::INTER_CUBIC);
  StereoCamera camera = testing::test_camera();
  camera.width_px *= 2;
  camera.height_px *= 2;
  camera.focal_px *= 2;
  camera.doffs_px *= 2;
  camera.centre_px = 2 * camera.centre_px + Eigen::Vector2d(0.5, 0.5);
  SegmentationOptions options;
  options.cues = CueLevel::disparity;
  const Segmentation found = segment(large, options, camera);
  ASSERT_EQ(found.objects.size(), 2u);
  cv::Mat truth;
  cv::resize(scene.instance_ids, truth, {}, 2, 2, cv::INTER_NEAREST);
  for (int id = 1; id <= 2; ++id) EXPECT_GT(overlap(truth == id, found), 0.8);
}

}  // namespace
}  // namespace graspctx
