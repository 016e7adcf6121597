#include <gtest/gtest.h>

#include <algorithm>
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

Segmentation segment(const CastScene& scene, CueLevel cues = CueLevel::colour) {
  SegmentationOptions options;
  options.cues = cues;
  return segment_objects(scene.pair, compute_disparity(scene.pair), testing::test_camera(), options);
}

TEST(RaisedObjects, OneBehindTheOtherAreTwo) {
  // The back box shows over and beside the front one, 6 cm behind it, in the same colour: only depth tells.
  const Box front{{0, -0.03, 0.03}, {0.04, 0.02, 0.03}, 0, {60, 90, 200}};
  const Box back{{0.03, 0.07, 0.06}, {0.05, 0.02, 0.06}, 0, {60, 90, 200}};
  const CastScene scene = testing::cast_scene(testing::test_camera(), {front, back});
  const Segmentation found = segment(scene, CueLevel::plane);
  EXPECT_EQ(found.objects.size(), 2u);
  EXPECT_GT(overlap(scene.instance_ids == 1, found), 0.8);
  EXPECT_GT(overlap(scene.instance_ids == 2, found), 0.8);
}

TEST(RaisedObjects, WhatStandsOnAThinStemIsOne) {
  // Seen from above, the foot lies under the bowl; in the image, far from it.
  const Eigen::Vector3d colour(60, 160, 90);
  const CastScene scene =
      testing::cast_scene(testing::test_camera(), {{{0, 0, 0.005}, {0.035, 0.035, 0.005}, 0, colour},
                                                   {{0, 0, 0.06}, {0.003, 0.003, 0.05}, 0, colour},
                                                   {{0, 0, 0.13}, {0.035, 0.035, 0.03}, 0, colour}});
  const Segmentation found = segment(scene);
  EXPECT_EQ(found.objects.size(), 1u);
  EXPECT_GT(overlap(scene.instance_ids > 0, found), 0.8);
}

TEST(RaisedObjects, AWallBehindTheTableIsNone) {
  const Box wall{{0, 0.4, 0.2}, {0.7, 0.01, 0.2}, 0.05, {120, 140, 150}};
  const Box box{{0.02, -0.02, 0.03}, {0.04, 0.03, 0.03}, 0.3, {60, 90, 200}};
  const CastScene scene = testing::cast_scene(testing::test_camera(), {wall, box});
  ASSERT_GT(cv::countNonZero(scene.instance_ids == 1), 10000);
  const Segmentation found = segment(scene);
  EXPECT_EQ(found.objects.size(), 1u);
  EXPECT_GT(overlap(scene.instance_ids == 2, found), 0.85);
}

TEST(RaisedObjects, ASecondPencilBesideTheFirst) {
  // Too low for steps in depth to tell them apart: a gap of 3 cm of table does.
  const Box left{{-0.02, 0, 0.0035}, {0.0035, 0.08, 0.0035}, 0.1, {50, 180, 190}};
  const Box right{{0.02, 0, 0.0035}, {0.0035, 0.08, 0.0035}, 0.1, {190, 80, 90}};
  const CastScene scene = testing::cast_scene(testing::test_camera(), {left, right});
  const Segmentation found = segment(scene);
  EXPECT_EQ(found.objects.size(), 2u);
  EXPECT_GT(overlap(scene.instance_ids == 1, found), 0.6);
  EXPECT_GT(overlap(scene.instance_ids == 2, found), 0.6);
}

}  // namespace
}  // namespace graspctx
