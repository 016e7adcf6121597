#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <ostream>
#include <string>

#include "graspctx/error.hpp"
#include "graspctx/segmentation.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::draw_mug;
using testing::DrawnMug;

double overlap(const cv::Mat& found, const cv::Mat& truth) {
  return static_cast<double>(cv::countNonZero(found & truth)) / cv::countNonZero(found | truth);
}

/// A mug as a camera sees it on a sheet of paper: shaded like a cylinder, a falling-off light, a shadow
/// beside it, soft edges, noise.
struct Photograph {
  cv::Mat image, mask, hole;
};

struct Look {
  cv::Scalar paper{235, 238, 240}, body{60, 80, 150};
  double fall_off = 0.2;      // of the light, from the middle to a corner
  double shadow = 0.3;        // share of the light it takes
  double penumbra_px = 8;     // 0: no softer than the edges of the object
  double shadow_to_px = -18;  // to the left, away from the handle
  double noise = 2;           // grey levels
};

Photograph photograph(const Look& look, std::uint32_t seed = 1) {
  const cv::Size size(320, 240);
  const int unit = 40;
  const cv::Point at(140, 100);
  const DrawnMug mug = draw_mug(size, at, unit);
  Photograph result{cv::Mat(size, CV_8UC3), mug.mask, {}};
  // What a flood from the corner does not reach is the inside of the handle, or mug.
  cv::Mat flooded = mug.mask.clone();
  cv::floodFill(flooded, {0, 0}, 255);
  result.hole = flooded == 0;

  cv::Mat cast = cv::Mat::zeros(size, CV_32FC1), solid;
  const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, look.shadow_to_px, 0, 1, 10);
  cv::warpAffine(mug.mask, solid, shift, size);
  solid.convertTo(cast, CV_32F, look.shadow / 255);
  cv::GaussianBlur(cast, cast, {0, 0}, std::max(0.7, look.penumbra_px));
  cv::Mat cover;
  mug.mask.convertTo(cover, CV_32F, 1 / 255.0);
  cv::GaussianBlur(cover, cover, {0, 0}, 0.6);
  std::mt19937 generator(seed);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const double x = (u - 160.0) / 200, y = (v - 120.0) / 200;
      const double light = 1 - look.fall_off * (x * x + y * y);
      const double across = std::clamp((u - at.x) / (1.7 * unit), -1.0, 1.0);
      const double shading = 0.45 + 0.55 * std::sqrt(1 - across * across);
      const double share = cover.at<float>(v, u);
      for (int c = 0; c < 3; ++c) {
        const double paper = look.paper[c] * light * (1 - cast.at<float>(v, u));
        const double noise = look.noise * std::sqrt(12.0) * (testing::uniform(generator) - 0.5);
        result.image.at<cv::Vec3b>(v, u)[c] =
            cv::saturate_cast<uchar>(share * look.body[c] * shading + (1 - share) * paper + noise);
      }
    }
  }
  return result;
}

struct Case {
  std::string name;
  Look look;
  double least_overlap;
  bool hole_is_lit = true;  // in a shadow it may stay part of the object
};

void PrintTo(const Case& one, std::ostream* out) {
  *out << one.name;
}

class PlainBackground : public ::testing::TestWithParam<Case> {};

TEST_P(PlainBackground, FindsTheObject) {
  const Photograph photo = photograph(GetParam().look);
  const cv::Mat found = plain_background_mask(photo.image);
  const double measured = overlap(found, photo.mask);
  RecordProperty("overlap", std::to_string(measured));
  EXPECT_GE(measured, GetParam().least_overlap);
  if (!GetParam().hole_is_lit) return;
  // The paper is seen through the handle.
  ASSERT_GT(cv::countNonZero(photo.hole), 200);
  EXPECT_LT(cv::countNonZero(found & photo.hole), 0.35 * cv::countNonZero(photo.hole));
}

Look look_with(void (*edit)(Look&)) {
  Look look;
  edit(look);
  return look;
}

INSTANTIATE_TEST_SUITE_P(
    Looks, PlainBackground,
    ::testing::Values(Case{"usual", {}, 0.95},  //
                      Case{"no_shadow", look_with([](Look& look) { look.shadow = 0; }), 0.95},
                      Case{"wide_penumbra", look_with([](Look& look) { look.penumbra_px = 20; }), 0.95},
                      Case{"deep_shadow", look_with([](Look& look) { look.shadow = 0.45; }), 0.87, false},
                      Case{"hard_shadow", look_with([](Look& look) { look.penumbra_px = 0; }), 0.9, false},
                      Case{"shadow_on_the_hole", look_with([](Look& look) { look.shadow_to_px = 18; }), 0.9,
                           false},
                      Case{"light_falls_off", look_with([](Look& look) { look.fall_off = 0.5; }), 0.9, false},
                      Case{"noise", look_with([](Look& look) { look.noise = 5; }), 0.93},
                      Case{"tinted_paper", look_with([](Look& look) {
                             look.paper = {190, 220, 235};
                           }),
                           0.95},
                      Case{"dark_grey_object", look_with([](Look& look) {
                             look.body = {70, 70, 70};
                           }),
                           0.95},
                      Case{"grey_object", look_with([](Look& look) {
                             look.body = {140, 140, 140}, look.shadow = 0.15;
                           }),
                           0.9}),
    [](const auto& parameter) { return parameter.param.name; });

TEST(PlainBackgroundMask, IsEmptyWhereNothingStandsOut) {
  EXPECT_EQ(cv::countNonZero(plain_background_mask(cv::Mat(90, 120, CV_8UC3, cv::Scalar(230, 230, 230)))), 0);
  Look look;
  look.body = look.paper;
  look.shadow = 0;
  cv::Mat paper = photograph(look).image(cv::Rect(0, 0, 60, 60));
  EXPECT_EQ(cv::countNonZero(plain_background_mask(paper)), 0);
}

TEST(PlainBackgroundMask, PrefersWhatDoesNotTouchTheBorder) {
  cv::Mat image(120, 160, CV_8UC3, cv::Scalar(230, 230, 230));
  const cv::Rect object(60, 40, 30, 30), edge(0, 0, 160, 12);
  cv::rectangle(image, edge, cv::Scalar(20, 20, 20), cv::FILLED);
  cv::rectangle(image, object, cv::Scalar(30, 160, 40), cv::FILLED);
  EXPECT_EQ(cv::boundingRect(plain_background_mask(image)), object);
  image(object) = cv::Scalar(230, 230, 230);
  EXPECT_GT(cv::countNonZero(plain_background_mask(image)), 1500);  // nothing else is there
}

TEST(PlainBackgroundMask, TakesGreyImages) {
  const Photograph photo = photograph({});
  cv::Mat grey;
  cv::cvtColor(photo.image, grey, cv::COLOR_BGR2GRAY);
  EXPECT_GE(overlap(plain_background_mask(grey), photo.mask), 0.9);
}

TEST(PlainBackgroundMask, RefusesWhatIsNoImage) {
  EXPECT_THROW(plain_background_mask(cv::Mat()), InvalidInput);
  EXPECT_THROW(plain_background_mask(cv::Mat(100, 100, CV_16UC1)), InvalidInput);
  EXPECT_THROW(plain_background_mask(cv::Mat(4, 100, CV_8UC1)), InvalidInput);
}

}  // namespace
}  // namespace graspctx
