#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "detail/background_planes.hpp"
#include "graspctx/segmentation.hpp"
#include "overlap.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;
using testing::overlap;
using testing::test_camera;

TEST(BackgroundPlanes, OfARoomCornerAreBothWalls) {
  cv::Mat disparity(240, 320, CV_32FC1);
  const auto left = [](int u, int v) { return 40 - 0.1 * u + 0.01 * v; };
  const auto right = [](int u, int v) { return 0.15 * u - 0.02 * v; };
  for (int v = 0; v < disparity.rows; ++v) {
    for (int u = 0; u < disparity.cols; ++u) {
      const double wall = u < 120 ? left(u, v) : right(u, v);
      const bool unknown = (u * 7 + v * 13) % 5 == 0;
      disparity.at<float>(v, u) = unknown ? std::numeric_limits<float>::quiet_NaN()
                                          : static_cast<float>(wall + 0.2 * ((u * 31 + v * 17) % 7 - 3) / 3);
    }
  }
  disparity(cv::Rect(150, 60, 30, 40)).setTo(70);
  const auto planes = detail::background_planes(disparity, 0.2, 3);
  ASSERT_EQ(planes.size(), 2u);
  EXPECT_NEAR(planes[0].disparity_px(250, 100), right(250, 100), 0.1);
  EXPECT_NEAR(planes[1].disparity_px(50, 100), left(50, 100), 0.1);
  EXPECT_EQ(detail::background_planes(disparity, 0.2, 1).size(), 1u);
  EXPECT_TRUE(detail::background_planes(disparity, 0.9, 3).empty());
  disparity.setTo(std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(detail::background_planes(disparity, 0.2, 3).empty());
}

/// Checked cloth on a wall seen from the side, all over both views; hardly more than its noise tells one cell
/// from the next.
RectifiedPair checked_wall(double cell_px) {
  RectifiedPair pair;
  for (const bool left : {true, false}) {
    cv::Mat view(480, 640, CV_8UC3);
    for (int v = 0; v < view.rows; ++v) {
      for (int u = 0; u < view.cols; ++u) {
        constexpr double disparity_px = 70, slope = -0.05;  // of the left view's columns
        const double u_left = left ? u : (u + disparity_px) / (1 - slope);
        const double x = (u_left + 100) / cell_px * (1 + u_left / 2000), y = v / cell_px;
        const int checks = (std::fmod(x, 1) < 0.5 ? 50 : 0) + (std::fmod(y, 1) < 0.5 ? 50 : 0);
        const double own = 15 * testing::solid_noise({x, y, 0}, 0.3, 5);
        view.at<cv::Vec3b>(v, u) = cv::Vec3b::all(cv::saturate_cast<uchar>(90 + checks + own));
      }
    }
    (left ? pair.left : pair.right) = view;
  }
  testing::add_noise(pair, 2);
  return pair;
}

TEST(BackgroundPlanes, AWallWhoseTextureRepeatsHoldsNothing) {
  for (const double cell_px : {14.0, 25.0}) {
    const RectifiedPair pair = checked_wall(cell_px);
    for (const CueLevel cues : {CueLevel::disparity, CueLevel::plane, CueLevel::colour}) {
      SegmentationOptions options;
      options.cues = cues;
      EXPECT_TRUE(segment_objects(pair, compute_disparity(pair), test_camera(), options).objects.empty())
          << cell_px << " " << name_of(cues);
    }
  }
}

TEST(BackgroundPlanes, WhatIsPaintedOnAFaintWallIsNoObject) {
  // The camera looks straight at it; what stands out by 6 cm does not belong to it.
  const Eigen::Vector3d paint(130, 135, 128);
  std::vector<Box> boxes{{{-0.1, 0.12, 0.0001}, {0.09, 0.008, 0.0001}, 0, paint},
                         {{0.15, -0.1, 0.0001}, {0.09, 0.008, 0.0001}, 0, paint}};
  const auto wall = testing::look_at_table(0.9, 1.5707, 0);
  for (const bool object : {false, true}) {
    if (object) boxes.push_back({{0.1, 0.1, 0.03}, {0.04, 0.03, 0.03}, 0.3, {60, 90, 200}});
    CastScene scene = testing::cast_scene(test_camera(), boxes, wall, {}, 5);
    testing::add_noise(scene.pair, 1);
    const Segmentation found = segment_objects(scene.pair, compute_disparity(scene.pair), test_camera());
    EXPECT_FALSE(found.table);
    ASSERT_EQ(found.objects.size(), object ? 1u : 0u);
    if (object) {
      EXPECT_GT(overlap(scene, 3, found), 0.8);
    }
  }
}

TEST(BackgroundPlanes, AWallThatTouchesTheTableIsNoObjectInPieces) {
  // A pillar leaves two pieces of wall; what stands before it is one object.
  const Box left{{-0.32, 0.25, 0.2}, {0.24, 0.01, 0.2}, 0, {120, 140, 150}};
  const Box right{{0.32, 0.25, 0.2}, {0.24, 0.01, 0.2}, 0, {120, 140, 150}};
  const Box box{{0.02, -0.02, 0.03}, {0.04, 0.03, 0.03}, 0.3, {60, 90, 200}};
  const testing::TableEdges edges{{-1, -1}, {1, 0.26}, -0.5};
  CastScene scene = testing::cast_scene(test_camera(), {left, right, box}, testing::look_at_table(), edges);
  testing::add_noise(scene.pair, 1);
  const Segmentation found = segment_objects(scene.pair, compute_disparity(scene.pair), test_camera());
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_GT(overlap(scene, 3, found), 0.85);
}

}  // namespace
}  // namespace graspctx
