// What is too low or thin for the matcher, and told from the table by its colour.
#include <gtest/gtest.h>

#include <cmath>
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
using testing::test_camera;

Segmentation segment(CastScene scene, const SegmentationOptions& options = {}) {
  testing::add_noise(scene.pair, 2);
  return segment_objects(scene.pair, compute_disparity(scene.pair), test_camera(), options);
}

/// A stick without texture, 5 mm high and wide, on a table with much of it, 90 cm away.
CastScene stick_on_table() {
  return testing::cast_scene(test_camera(), {{{0, 0, 0.0025}, {0.08, 0.0025, 0.0025}, 0.35, {60, 60, 200}}},
                             testing::look_at_table(0.9), {}, 60, 1);
}

TEST(StrangeColours, AThinStickIsFoundWhole) {
  const CastScene scene = stick_on_table();
  const Segmentation found = segment(scene);
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_GT(overlap(scene, 1, found), 0.75);
}

TEST(StrangeColours, AHandleOnTheTableBelongsToItsHead) {
  const Eigen::Vector3d colour(60, 60, 200);
  const CastScene scene =
      testing::cast_scene(test_camera(), {{{0.09, 0, 0.009}, {0.02, 0.015, 0.009}, 0, colour},
                                          {{0, 0, 0.001}, {0.07, 0.003, 0.001}, 0, colour}});
  const Segmentation found = segment(scene);
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_GT(overlap(scene.instance_ids > 0, found), 0.8);
}

TEST(StrangeColours, WhatIsPaintedOrShadedLiesOnTheTable) {
  // The same stick, but flat: the table's disparities.
  for (const bool shade : {false, true}) {
    CastScene scene = testing::cast_scene(test_camera(), {}, testing::look_at_table(0.9));
    const cv::Mat stick = stick_on_table().instance_ids > 0;
    cv::Mat in_right = cv::Mat::zeros(stick.size(), CV_8UC1);
    const auto paint = [&](cv::Vec3b& pixel) { pixel = shade ? 0.4 * pixel : cv::Vec3b(60, 60, 200); };
    for (int v = 0; v < stick.rows; ++v) {
      for (int u = 0; u < stick.cols; ++u) {
        if (!stick.at<uchar>(v, u)) continue;
        paint(scene.pair.left.at<cv::Vec3b>(v, u));
        in_right.at<uchar>(v, u - static_cast<int>(std::lround(scene.disparity.at<float>(v, u)))) = 255;
      }
    }
    cv::morphologyEx(in_right, in_right, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
    for (int v = 0; v < stick.rows; ++v) {
      for (int u = 0; u < stick.cols; ++u) {
        if (in_right.at<uchar>(v, u)) paint(scene.pair.right.at<cv::Vec3b>(v, u));
      }
    }
    EXPECT_TRUE(segment(scene).objects.empty()) << (shade ? "shaded" : "painted");
  }
}

TEST(StrangeColours, LimitsOnSizeAreKept) {
  const CastScene scene = stick_on_table();
  SegmentationOptions options;
  options.max_extent_m = 0.1;
  EXPECT_LT(overlap(scene, 1, segment(scene, options)), 0.3);
  options = {};
  options.min_height_m = 0.06;
  EXPECT_TRUE(segment(scene, options).objects.empty());
}

}  // namespace
}  // namespace graspctx
