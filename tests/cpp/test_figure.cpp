// The masks of objects that were found: what shows through them, what lies inside them, what they shade.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "graspctx/segmentation.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::cast_scene;
using testing::CastScene;
using testing::test_camera;

/// With noise as of a camera, without which nothing is uncertain.
Segmentation segment(CastScene scene, CueLevel cues) {
  testing::add_noise(scene.pair, 1);
  SegmentationOptions options;
  options.cues = cues;
  return segment_objects(scene.pair, compute_disparity(scene.pair), test_camera(), options);
}

double share(const cv::Mat& mask, const cv::Mat& of) {
  return static_cast<double>(cv::countNonZero(mask & of)) / std::max(1, cv::countNonZero(of));
}

/// Changes the colour of the pixels of a mask of the left view, and of the same points in the right view.
template <typename Change>
void change_colours(CastScene& scene, const cv::Mat& mask, const Change& change) {
  cv::Mat in_right = cv::Mat::zeros(mask.size(), CV_8UC1);
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      if (!mask.at<uchar>(v, u)) continue;
      change(scene.pair.left.at<cv::Vec3b>(v, u));
      const int there = u - static_cast<int>(std::lround(scene.disparity.at<float>(v, u)));
      if (there >= 0) in_right.at<uchar>(v, there) = 255;
    }
  }
  cv::morphologyEx(in_right, in_right, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      if (in_right.at<uchar>(v, u)) change(scene.pair.right.at<cv::Vec3b>(v, u));
    }
  }
}

TEST(Figure, TheTableShowsThroughAHandle) {
  const Eigen::Vector3d colour(60, 60, 200);
  const double x = 0.045, reach_m = 0.012;  // the handle stands out to the right of the body
  const std::vector<Box> mug{{{0, 0, 0.05}, {0.035, 0.03, 0.05}, 0, colour},
                             {{x, 0, 0.067}, {reach_m, 0.005, 0.005}, 0, colour},
                             {{x, 0, 0.025}, {reach_m, 0.005, 0.005}, 0, colour},
                             {{x + reach_m, 0, 0.046}, {0.005, 0.005, 0.026}, 0, colour}};
  const CastScene scene = cast_scene(test_camera(), mug);
  const cv::Mat object = scene.instance_ids > 0;
  cv::Mat outside = object.clone();
  cv::floodFill(outside, {0, 0}, 255);
  const cv::Mat hole = ~outside;
  ASSERT_GT(cv::countNonZero(hole), 60);

  // Whether the handle is one object with the body is not asked here: both are boxes.
  const Segmentation found = segment(scene, CueLevel::colour);
  EXPECT_LT(share(found.instance_ids > 0, hole), 0.2);
  EXPECT_GT(share(found.instance_ids > 0, object), 0.9);
}

TEST(Figure, APlainMiddleBelongsToWhatIsRaisedAroundIt) {
  CastScene scene = cast_scene(test_camera(), {{{0, 0, 0.04}, {0.06, 0.04, 0.04}, 0.3}});
  const cv::Mat object = scene.instance_ids > 0;
  cv::Mat middle;
  cv::erode(object, middle, cv::Mat::ones(25, 25, CV_8U));
  ASSERT_GT(share(middle, object), 0.2);
  change_colours(scene, middle, [](cv::Vec3b& pixel) { pixel = {90, 120, 200}; });

  const Segmentation found = segment(scene, CueLevel::plane);
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_GT(share(found.instance_ids > 0, middle), 0.95);
  EXPECT_LT(share(found.instance_ids > 0, ~object), 0.02);
}

TEST(Figure, AShadowIsTable) {
  CastScene scene = cast_scene(test_camera(), {{{0, 0, 0.04}, {0.04, 0.04, 0.04}, 0.3, {60, 60, 200}}});
  const cv::Mat object = scene.instance_ids > 0;
  // To the left of the object, where the right camera sees it only in part, and too dark to show texture.
  cv::Mat shadow;
  cv::warpAffine(object, shadow, cv::Matx23d(1, 0, -60, 0, 1, 25), object.size(), cv::INTER_NEAREST);
  shadow &= ~object;
  change_colours(scene, shadow, [](cv::Vec3b& pixel) { pixel = {52, 52, 49}; });

  const Segmentation found = segment(scene, CueLevel::colour);
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_LT(share(found.instance_ids > 0, shadow), 0.1);
  EXPECT_GT(share(found.instance_ids > 0, object), 0.9);
}

}  // namespace
}  // namespace graspctx
