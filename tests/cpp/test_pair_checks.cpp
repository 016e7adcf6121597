#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "graspctx/segmentation.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;

const CastScene& box_scene() {
  static const CastScene scene = [] {
    CastScene cast =
        testing::cast_scene(testing::test_camera(), {Box{{0, 0, 0.04}, {0.06, 0.04, 0.04}, 0.5}});
    testing::add_noise(cast.pair, 1);
    return cast;
  }();
  return scene;
}

Segmentation segment(const RectifiedPair& pair, CueLevel cues = CueLevel::colour) {
  SegmentationOptions options;
  options.cues = cues;
  return segment_objects(pair, compute_disparity(pair), testing::test_camera(), options);
}

/// The right view turned about its middle, and then lower by a number of pixels.
RectifiedPair misaligned(const RectifiedPair& pair, double lower_px, double turn_rad = 0) {
  const double c = std::cos(turn_rad), s = std::sin(turn_rad);
  const double u = 0.5 * (pair.right.cols - 1), v = 0.5 * (pair.right.rows - 1);
  const cv::Matx23d moved_from_view(c, -s, u - c * u + s * v, s, c, v - s * u - c * v + lower_px);
  RectifiedPair moved{pair.left, {}};
  cv::warpAffine(pair.right, moved.right, moved_from_view, pair.right.size(), cv::INTER_CUBIC,
                 cv::BORDER_REPLICATE);
  return moved;
}

bool says(const Segmentation& segmentation, const std::string& words) {
  for (const std::string& warning : segmentation.warnings) {
    if (warning.find(words) != std::string::npos) return true;
  }
  return false;
}

class VerticalOffset : public ::testing::TestWithParam<double> {};

TEST_P(VerticalOffset, IsMeasuredToATenthOfAPixelAndWarnedAboutWithTheNumber) {
  const double offset_px = GetParam();
  const Segmentation found = segment(misaligned(box_scene().pair, offset_px));
  ASSERT_TRUE(found.vertical_offset_px);
  EXPECT_NEAR(*found.vertical_offset_px, offset_px, 0.1);
  EXPECT_EQ(says(found, "misaligned vertically"), std::abs(offset_px) >= 0.7);
  EXPECT_FALSE(says(found, "turned"));
}

INSTANTIATE_TEST_SUITE_P(UpAndDown, VerticalOffset,
                         ::testing::Values(-4.0, -1.25, -0.4, 0.0, 0.5, 1.0, 2.5, 4.0));

TEST(PairChecks, TheNumberAndTheSideStandInTheWarning) {
  EXPECT_TRUE(says(segment(misaligned(box_scene().pair, 3)), "vertically by 3 px, the right one is too low"));
  EXPECT_TRUE(says(segment(misaligned(box_scene().pair, -2.5)), "by 2.5 px, the right one is too high"));
}

TEST(PairChecks, AMirroredPairIsMisalignedAsMuch) {
  const RectifiedPair pair = misaligned(box_scene().pair, 1.5);
  RectifiedPair mirrored;  // the views change sides
  cv::flip(pair.right, mirrored.left, 1);
  cv::flip(pair.left, mirrored.right, 1);
  const Segmentation found = segment(mirrored);
  ASSERT_TRUE(found.vertical_offset_px);
  EXPECT_NEAR(*found.vertical_offset_px, -1.5, 0.1);
}

TEST(PairChecks, ATurnedRightViewIsWarnedAbout) {
  const double degree = CV_PI / 180;
  EXPECT_FALSE(says(segment(misaligned(box_scene().pair, 0, 0.05 * degree)), "turned"));
  const Segmentation found = segment(misaligned(box_scene().pair, 0, 0.5 * degree));
  EXPECT_TRUE(says(found, "the right view is turned by 0.5") ||
              says(found, "the right view is turned by 0.4"))
      << ::testing::PrintToString(found.warnings);
}

TEST(PairChecks, ASlantedEdgeTellsNoVerticalOffset) {
  // Along an edge a shift of the row and one of the disparity look the same.
  RectifiedPair pair;
  for (const bool left : {true, false}) {
    cv::Mat image(480, 640, CV_8UC3, cv::Scalar::all(90));
    for (int i = -2; i < 8; ++i) {
      const int u = 100 * i + (left ? 0 : -40);
      const std::vector<cv::Point> stripe{{u, 0}, {u + 30, 0}, {u + 230, 480}, {u + 200, 480}};
      cv::fillPoly(image, std::vector<std::vector<cv::Point>>{stripe}, cv::Scalar::all(170), cv::LINE_AA);
    }
    (left ? pair.left : pair.right) = image;
  }
  testing::add_noise(pair, 1);
  EXPECT_FALSE(segment(pair).vertical_offset_px);
}

void add_dots(cv::Mat& image, std::mt19937& generator) {
  for (int i = 0; i < 10; ++i) {
    const cv::Point at(static_cast<int>(testing::uniform(generator, 20, 620)),
                       static_cast<int>(testing::uniform(generator, 20, 460)));
    const auto grey = testing::uniform(generator, 0, 255);
    cv::circle(image, at, static_cast<int>(testing::uniform(generator, 1, 4)), cv::Scalar::all(grey),
               cv::FILLED, cv::LINE_AA);
  }
}

TEST(PairChecks, WhatHoldsNoDepthHoldsNoObject) {
  const RectifiedPair& pair = box_scene().pair;
  const cv::Mat plain(480, 640, CV_8UC3, cv::Scalar(120, 130, 140));
  const cv::Mat black = cv::Mat::zeros(480, 640, CV_8UC3);
  std::mt19937 generator(5);
  RectifiedPair dots{plain.clone(), plain.clone()}, noisy_dots, grain{plain.clone(), plain.clone()};
  add_dots(dots.left, generator);
  add_dots(dots.right, generator);
  noisy_dots = {dots.left.clone(), dots.right.clone()};
  testing::add_noise(noisy_dots, 3);
  testing::add_noise(grain, 8);
  RectifiedPair twice{pair.left.clone(), pair.left.clone()};
  testing::add_noise(twice, 2);
  const std::vector<std::pair<std::string, RectifiedPair>> cases{
      {"left view black", {black, pair.right}}, {"right view black", {pair.left, black}},
      {"both views black", {black, black}},     {"dots", dots},
      {"dots and noise", noisy_dots},           {"noise", grain},
      {"the same picture and noise", twice}};
  for (const auto& [name, views] : cases) {
    for (const CueLevel cues : {CueLevel::disparity, CueLevel::plane, CueLevel::colour}) {
      const Segmentation found = segment(views, cues);
      EXPECT_TRUE(found.objects.empty()) << name;
      EXPECT_FALSE(found.warnings.empty()) << name;
    }
  }
  EXPECT_TRUE(says(segment({black, black}), "hardly any texture"));
  // The same dots in both views, as dust in front of them, are no objects either; a pencil's outline is more.
  RectifiedPair dust{plain.clone(), plain.clone()};
  std::mt19937 again(6), and_again(6);
  add_dots(dust.left, again);
  add_dots(dust.right, and_again);
  cv::warpAffine(dust.right, dust.right, cv::Matx23d(1, 0, -40, 0, 1, 0), dust.right.size(), cv::INTER_LINEAR,
                 cv::BORDER_REPLICATE);
  EXPECT_TRUE(says(segment(dust), "nothing but specks"));
  cv::rectangle(dust.left, cv::Rect(300, 200, 100, 6), cv::Scalar(20, 20, 30), cv::FILLED);
  cv::rectangle(dust.right, cv::Rect(260, 200, 100, 6), cv::Scalar(20, 20, 30), cv::FILLED);
  EXPECT_FALSE(says(segment(dust), "specks"));
  EXPECT_TRUE(says(segment(twice), "the same picture"));
  EXPECT_TRUE(says(segment({pair.left, black}), "not a rectified stereo pair"));
}

TEST(PairChecks, ARealPairIsNotRefusedInAnotherLight) {
  for (const double gain : {0.4, 0.8, 1.2}) {
    RectifiedPair pair;
    box_scene().pair.left.convertTo(pair.left, -1, gain);
    box_scene().pair.right.convertTo(pair.right, -1, 0.95 * gain);
    const Segmentation found = segment(pair);
    EXPECT_EQ(found.objects.size(), 1U) << gain;
    EXPECT_TRUE(found.warnings.empty()) << gain << ::testing::PrintToString(found.warnings);
  }
}

}  // namespace
}  // namespace graspctx
