#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "detail/refined_mask.hpp"
#include "overlap.hpp"
#include "synthetic.hpp"

namespace graspctx::detail {
namespace {

/// Colours without any noise are like no camera's, and nothing that a mixture of normal colours could be of.
testing::DrawnMug draw_mug(int unit = 60) {
  testing::DrawnMug mug = testing::draw_mug({640, 480}, {300, 220}, unit);
  RectifiedPair pair{mug.image, mug.image.clone()};
  testing::add_noise(pair, 3);
  return mug;
}

cv::Mat dilated(const cv::Mat& mask, int radius_px) {
  cv::Mat larger;
  const int side_px = 2 * radius_px + 1;
  cv::dilate(mask, larger, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side_px, side_px}));
  return larger;
}

TEST(RefinedMask, BringsAMaskThatIsTooLargeBackToTheObject) {
  for (const int unit : {20, 60}) {  // the larger one is cut in a smaller picture
    const auto mug = draw_mug(unit);
    for (const double share : {0.2, 0.5}) {
      const cv::Mat given = dilated(mug.mask, static_cast<int>(share * unit));
      EXPECT_LT(testing::iou(given, mug.mask), 0.9);
      EXPECT_GT(testing::iou(refined_mask(mug.image, given), mug.mask), 0.93) << unit << ", " << share;
    }
  }
}

TEST(RefinedMask, TakesAWedgeOfTheTableAway) {
  const auto mug = draw_mug();
  const cv::Rect box = cv::boundingRect(mug.mask);
  cv::Mat given = mug.mask.clone();
  cv::rectangle(given, {box.x, box.y + box.height - 5, box.width / 2, 40}, cv::Scalar(255), cv::FILLED);
  EXPECT_GT(testing::iou(refined_mask(mug.image, given), mug.mask), 0.97);
}

TEST(RefinedMask, LeavesTheTrueMaskAlone) {
  const auto mug = draw_mug();
  EXPECT_GT(testing::iou(refined_mask(mug.image, mug.mask), mug.mask), 0.99);
}

TEST(RefinedMask, NeverTakesMoreThanTheMask) {
  const auto mug = draw_mug();
  const cv::Mat part = mug.mask.clone();
  part.colRange(0, part.cols / 2).setTo(0);
  EXPECT_EQ(cv::countNonZero(refined_mask(mug.image, part) & ~part), 0);
}

TEST(RefinedMask, WorksOnGreyImages) {
  const auto mug = draw_mug();
  cv::Mat grey;
  cv::cvtColor(mug.image, grey, cv::COLOR_BGR2GRAY);
  EXPECT_GT(testing::iou(refined_mask(grey, dilated(mug.mask, 12)), mug.mask), 0.95);
}

TEST(RefinedMask, IsTheSameWhateverOpenCvDrewBefore) {
  const auto mug = draw_mug();
  const cv::Mat given = dilated(mug.mask, 10);
  cv::theRNG() = cv::RNG(17);
  const cv::Mat first = refined_mask(mug.image, given);
  EXPECT_EQ(cv::theRNG().state, cv::RNG(17).state);  // as it was
  cv::theRNG() = cv::RNG(4242);
  EXPECT_EQ(cv::norm(first, refined_mask(mug.image, given), cv::NORM_INF), 0);
}

TEST(RefinedMask, KeepsTheMaskWhereThereIsNothingToLearnFrom) {
  const auto mug = draw_mug();
  const cv::Mat all(mug.image.size(), CV_8UC1, cv::Scalar(255));
  EXPECT_EQ(cv::countNonZero(refined_mask(mug.image, all)), mug.image.size().area());
  cv::Mat few = cv::Mat::zeros(mug.image.size(), CV_8UC1);
  few.at<uchar>(0, 0) = few.at<uchar>(0, 1) = 255;  // in a corner
  EXPECT_EQ(cv::countNonZero(refined_mask(mug.image, few)), 2);
  const cv::Mat plain(mug.image.size(), CV_8UC3, cv::Scalar(90, 90, 90));  // one colour
  EXPECT_GT(cv::countNonZero(refined_mask(plain, mug.mask)), 0);
}

}  // namespace
}  // namespace graspctx::detail
