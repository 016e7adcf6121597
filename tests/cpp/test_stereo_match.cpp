#include <gtest/gtest.h>

#include <cmath>

#include "graspctx/error.hpp"
#include "graspctx/stereo_match.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// A textured rectangle at one disparity before a background at another.
FovealPair rectangle_pair(double disparity_px, double background_px, double fixation_px) {
  const cv::Mat texture = testing::random_texture({640, 480}, 11),
                ground = testing::random_texture({640, 480}, 12);
  cv::Mat mask = cv::Mat::zeros(480, 640, CV_8UC1);
  cv::rectangle(mask, {250, 180, 100, 80}, cv::Scalar(255), cv::FILLED);
  RectifiedPair pair;
  pair.left = ground.clone();
  texture.copyTo(pair.left, mask);
  const auto moved = [](const cv::Mat& image, double by) {
    cv::Mat result;
    cv::warpAffine(image, result, cv::Matx23d(1, 0, -by, 0, 1, 0), image.size(), cv::INTER_LINEAR,
                   cv::BORDER_REFLECT);
    return result;
  };
  pair.right = moved(ground, background_px);
  moved(texture, disparity_px).copyTo(pair.right, moved(mask, disparity_px) > 127);
  const cv::Mat disparity(480, 640, CV_32FC1, cv::Scalar(fixation_px));
  return *foveal_pair(pair, mask, disparity);
}

TEST(StereoMatch, FindsTheDisparityToATenthOfAPixel) {
  for (const double disparity_px : {40.0, 41.3, 43.75}) {
    const FovealPair pair = rectangle_pair(disparity_px, 20, 42);
    for (const Eigen::Vector2d& image_px :
         {Eigen::Vector2d(300, 220), Eigen::Vector2d(280, 200), Eigen::Vector2d(330, 245)}) {
      const auto match = match_patch(pair, pair.left.view_from_image(image_px), unknown);
      ASSERT_TRUE(match) << disparity_px;
      EXPECT_NEAR(match->disparity_px, disparity_px, 0.1);
      EXPECT_GT(match->correlation, 0.9);
      EXPECT_GT(match->disparity_stddev_px, 0);
      const double right_u = pair.right.image_from_view(match->right_view_px).x();
      EXPECT_NEAR(image_px.x() - right_u, match->disparity_px, 0.02);
    }
  }
}

TEST(StereoMatch, AtTheOutlineTheObjectWinsOverTheBackground) {
  const FovealPair pair = rectangle_pair(44, 30, 44);
  int right = 0;
  for (int v = 190; v < 255; v += 8) {
    const auto match = match_patch(pair, pair.left.view_from_image({252, v}), unknown);
    if (match && std::abs(match->disparity_px - 44) < 0.5) ++right;
  }
  EXPECT_GE(right, 8);  // of 9
}

TEST(StereoMatch, APriorNarrowsTheSearch) {
  const FovealPair pair = rectangle_pair(40, 20, 42);
  const Eigen::Vector2d view_px = pair.left.view_from_image({300, 220});
  EXPECT_NEAR(match_patch(pair, view_px, 40.5)->disparity_px, 40, 0.1);
  EXPECT_FALSE(match_patch(pair, view_px, 90));
}

TEST(StereoMatch, NothingWithoutTextureOrOutsideTheView) {
  FovealPair pair = rectangle_pair(40, 20, 40);
  EXPECT_FALSE(match_patch(pair, {2, 2}, unknown));
  pair.left.image.setTo(cv::Scalar(90, 90, 90));
  pair.right.image.setTo(cv::Scalar(90, 90, 90));
  EXPECT_FALSE(match_patch(pair, pair.left.view_from_image({300, 220}), unknown));
}

TEST(StereoMatch, RefusesBadOptions) {
  StereoMatchOptions options;
  options.window_px = 20;
  EXPECT_THROW(match_patch(rectangle_pair(40, 20, 40), {100, 100}, unknown, options), InvalidInput);
}

}  // namespace
}  // namespace graspctx
