#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "graspctx/segmentation.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;

const Box tall_box{{-0.08, 0.03, 0.05}, {0.03, 0.02, 0.05}, 0.4, {60, 90, 200}};
const Box flat_box{{0.09, 0.02, 0.02}, {0.05, 0.035, 0.02}, -0.3, {190, 120, 60}};

const CastScene& two_boxes() {
  static const CastScene scene = testing::cast_scene(testing::test_camera(), {tall_box, flat_box});
  return scene;
}

Segmentation segment(const CastScene& scene, const SegmentationOptions& options = {},
                     const StereoCamera& camera = testing::test_camera()) {
  return segment_objects(scene.pair, compute_disparity(scene.pair), camera, options);
}

/// What was found of a true object: the hypothesis that holds most of it.
const ObjectHypothesis* found_of(const CastScene& scene, int true_id, const Segmentation& found) {
  const auto shared = [&](const ObjectHypothesis& object) {
    return cv::countNonZero((found.instance_ids == object.id) & (scene.instance_ids == true_id));
  };
  const auto best = std::max_element(found.objects.begin(), found.objects.end(),
                                     [&](const auto& a, const auto& b) { return shared(a) < shared(b); });
  return best == found.objects.end() || shared(*best) == 0 ? nullptr : &*best;
}

TEST(ObjectMeasures, AreMetric) {
  const Segmentation found = segment(two_boxes());
  const Box boxes[] = {tall_box, flat_box};
  for (int id = 1; id <= 2; ++id) {
    const ObjectHypothesis* object = found_of(two_boxes(), id, found);
    ASSERT_TRUE(object);
    ASSERT_TRUE(object->size_m);
    const Eigen::Vector3d expected_m = 2 * boxes[id - 1].half_m;
    EXPECT_NEAR(object->size_m->x(), expected_m.x(), 0.008) << id;
    EXPECT_NEAR(object->size_m->y(), expected_m.y(), 0.008) << id;
    EXPECT_NEAR(object->size_m->z(), expected_m.z(), 0.004) << id;
    EXPECT_FALSE(object->leaves_table);
  }
}

TEST(ObjectMeasures, GrowWithTheScene) {
  // Twice the baseline, and the same images show a scene twice as large.
  StereoCamera wide = testing::test_camera();
  wide.baseline_m *= 2;
  SegmentationOptions options;
  const Segmentation small = segment(two_boxes(), options);
  options.cell_m *= 2;
  options.min_height_m *= 2;
  options.max_height_m *= 2;
  options.min_extent_m *= 2;
  options.max_extent_m *= 2;
  const Segmentation large = segment(two_boxes(), options, wide);
  for (int id = 1; id <= 2; ++id) {
    const ObjectHypothesis *a = found_of(two_boxes(), id, small), *b = found_of(two_boxes(), id, large);
    ASSERT_TRUE(a && b && a->size_m && b->size_m);
    EXPECT_LT((2 * *a->size_m - *b->size_m).cwiseAbs().maxCoeff(), 0.01) << id;
    EXPECT_NEAR(b->saliency, 2 * a->saliency, 0.1 * b->saliency) << id;
  }
}

TEST(ObjectMeasures, NeedAPlane) {
  SegmentationOptions options;
  options.cues = CueLevel::disparity;
  const Segmentation found = segment(two_boxes(), options);
  ASSERT_FALSE(found.objects.empty());
  for (const ObjectHypothesis& object : found.objects) {
    EXPECT_FALSE(object.size_m);
    EXPECT_FALSE(object.leaves_table);
    EXPECT_GT(object.saliency, 0);
  }
}

TEST(ObjectMeasures, TellWhatHangsOverTheEdge) {
  // A bar over the left edge, a box well on the table, and one on it that the image cuts off.
  const Box bar{{-0.2, -0.06, 0.02}, {0.07, 0.015, 0.02}, 0.1, {60, 90, 200}};
  const Box inside{{0.02, 0.06, 0.03}, {0.03, 0.03, 0.03}, 0.3, {190, 120, 60}};
  const Box cut{{0.34, 0.02, 0.03}, {0.05, 0.03, 0.03}, 0, {60, 190, 90}};
  testing::TableEdges edges;
  edges.low_m.x() = -0.2;
  const CastScene scene =
      testing::cast_scene(testing::test_camera(), {bar, inside, cut}, testing::look_at_table(), edges);
  const Segmentation found = segment(scene);
  const bool leaves[] = {true, false, false}, touches[] = {false, false, true};
  for (int id = 1; id <= 3; ++id) {
    const ObjectHypothesis* object = found_of(scene, id, found);
    ASSERT_TRUE(object) << id;
    EXPECT_EQ(object->leaves_table, leaves[id - 1]) << id;
    EXPECT_EQ(object->touches_border, touches[id - 1]) << id;
  }
}

}  // namespace
}  // namespace graspctx
