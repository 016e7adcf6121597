#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "graspctx/contour.hpp"
#include "graspctx/error.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::draw_mug;

cv::Mat disc(const cv::Point& centre, int radius, uchar value = 200) {
  cv::Mat image(300, 300, CV_8UC1, cv::Scalar(50));
  cv::circle(image, centre, radius, cv::Scalar(value), cv::FILLED);
  return image;
}

TEST(Contour, SamplesACircleEvenlyWithRadialGradients) {
  const cv::Mat image = disc({150, 150}, 80);
  const Contour contour = sample_contour(image, image > 100);
  ASSERT_EQ(contour.points.size(), 300u);
  std::vector<int> per_sector(12, 0);
  for (std::size_t i = 0; i < contour.points.size(); ++i) {
    const cv::Point2f r = contour.points[i] - cv::Point2f(150, 150);
    EXPECT_NEAR(std::hypot(r.x, r.y), 80, 2.5);
    // Brighter inside: the gradient points at the centre.
    const double inwards = std::atan2(-r.y, -r.x);
    EXPECT_GT(std::cos(inwards - contour.gradients_rad[i]), 0.9);
    ++per_sector[static_cast<std::size_t>((std::atan2(r.y, r.x) / 6.283185307179586 + 1) * 12) % 12];
  }
  for (const int count : per_sector) EXPECT_NEAR(count, 25, 6);
}

TEST(Contour, IsTheSameEveryTime) {
  const auto mug = draw_mug();
  const Contour first = sample_contour(mug.image, mug.mask), second = sample_contour(mug.image, mug.mask);
  EXPECT_EQ(first.points, second.points);
  EXPECT_EQ(first.gradients_rad, second.gradients_rad);
}

TEST(Contour, MovesWithTheImage) {
  const auto mug = draw_mug({640, 480}, {260, 200}), moved = draw_mug({640, 480}, {273, 219});
  const Contour here = sample_contour(mug.image, mug.mask), there = sample_contour(moved.image, moved.mask);
  ASSERT_EQ(here.points.size(), there.points.size());
  for (std::size_t i = 0; i < here.points.size(); ++i) {
    EXPECT_EQ(here.points[i] + cv::Point2f(13, 19), there.points[i]);
  }
}

TEST(Contour, KeepsInnerEdgesAndLeavesTheBackgroundOut) {
  auto mug = draw_mug();
  cv::rectangle(mug.image, {20, 20, 60, 60}, cv::Scalar(0, 0, 0), cv::FILLED);  // not the object
  ContourOptions every_pixel;
  every_pixel.samples = 0;
  const Contour contour = sample_contour(mug.image, mug.mask, every_pixel);
  cv::Mat inner = cv::Mat::zeros(mug.mask.size(), CV_8UC1);
  cv::erode(mug.mask, inner, cv::Mat(), {-1, -1}, 8);
  int inside = 0;
  for (const cv::Point2f& p : contour.points) {
    EXPECT_GT(p.x, 90);
    if (inner.at<uchar>(cv::Point(p))) ++inside;
  }
  EXPECT_GT(inside, 200);  // the printed square: 4 × 60 px
}

TEST(Contour, AMaskTooLargeAddsNoFalseOutline) {
  const auto mug = draw_mug();
  cv::Mat large;
  cv::dilate(mug.mask, large, cv::getStructuringElement(cv::MORPH_ELLIPSE, {25, 25}));
  const Contour exact = sample_contour(mug.image, mug.mask), loose = sample_contour(mug.image, large);
  EXPECT_EQ(exact.points, loose.points);
}

TEST(Contour, TheOutlineStandsInWhereThereIsNoContrast) {
  const cv::Mat flat(200, 200, CV_8UC1, cv::Scalar(128));
  cv::Mat mask = cv::Mat::zeros(200, 200, CV_8UC1);
  cv::rectangle(mask, {50, 60, 80, 40}, cv::Scalar(255), cv::FILLED);
  const Contour contour = sample_contour(flat, mask);
  ASSERT_GT(contour.points.size(), 150u);
  for (const cv::Point2f& p : contour.points) {
    const bool on_outline = p.x == 50 || p.x == 129 || p.y == 60 || p.y == 99;
    EXPECT_TRUE(on_outline) << p;
  }
}

TEST(Contour, KnowsHowFarASampleIsInsideTheMask) {
  const auto mug = draw_mug({320, 240}, {120, 100}, 30);
  const auto naive = [](const cv::Mat& mask, const cv::Point2f& p) {
    double nearest = 1e9;
    for (int v = -1; v <= mask.rows; ++v) {
      for (int u = -1; u <= mask.cols; ++u) {
        const bool within = cv::Rect({0, 0}, mask.size()).contains(cv::Point(u, v)) && mask.at<uchar>(v, u);
        if (!within) nearest = std::min(nearest, std::hypot(double(p.x) - u, double(p.y) - v));
      }
    }
    return nearest;
  };
  ContourOptions few;
  few.samples = 60;
  const cv::Mat everywhere(mug.mask.size(), CV_8UC1, cv::Scalar(255));
  for (const cv::Mat& mask : {mug.mask, everywhere}) {
    const Contour contour = sample_contour(mug.image, mask, few);
    ASSERT_EQ(contour.border_px.size(), contour.points.size());
    for (std::size_t i = 0; i < contour.points.size(); ++i) {
      EXPECT_NEAR(contour.border_px[i], naive(mask, contour.points[i]), 1e-3);
    }
  }
  EXPECT_EQ(sample_contour(mug.image, {}, few).border_px,
            sample_contour(mug.image, everywhere, few).border_px);
}

TEST(Contour, RefusesBadInput) {
  const cv::Mat image(20, 20, CV_8UC3, cv::Scalar(0)), mask(20, 20, CV_8UC1, cv::Scalar(255));
  EXPECT_THROW(sample_contour({}, mask), InvalidInput);
  EXPECT_THROW(sample_contour(cv::Mat(20, 20, CV_16UC1), mask), InvalidInput);
  EXPECT_THROW(sample_contour(image, cv::Mat(20, 21, CV_8UC1)), InvalidInput);
  EXPECT_THROW(sample_contour(image, cv::Mat(20, 20, CV_8UC3)), InvalidInput);
  ContourOptions options;
  options.canny_low = 100;
  EXPECT_THROW(sample_contour(image, mask, options), InvalidInput);
  EXPECT_TRUE(sample_contour(image, cv::Mat()).points.empty());
}

}  // namespace
}  // namespace graspctx
