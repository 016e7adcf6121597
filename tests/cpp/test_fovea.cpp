#include <gtest/gtest.h>

#include "graspctx/error.hpp"
#include "graspctx/fovea.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

TEST(Fovea, ShowsTheObjectAtAFixedSize) {
  for (const int unit : {20, 45, 70}) {
    const auto mug = testing::draw_mug({640, 480}, {260, 220}, unit);
    const FovealView view = foveal_view(mug.image, mug.mask);
    const cv::Rect box = cv::boundingRect(view.mask);
    EXPECT_NEAR(std::max(box.width, box.height), 200, 8);
    EXPECT_NEAR(box.x, 40, 4);
    EXPECT_NEAR(box.y, 40, 4);
  }
}

TEST(Fovea, LeavesTheImageAlone) {
  const auto mug =
      testing::draw_mug({640, 480}, {260, 220}, 95);  // larger than the view: it is blurred and reduced
  const cv::Mat before = mug.image.clone();
  const FovealView view = foveal_view(mug.image, mug.mask);
  ASSERT_LT(view.scale, 1);
  EXPECT_EQ(cv::norm(before, mug.image, cv::NORM_INF), 0);
}

TEST(Fovea, MapsPixelsToAndFro) {
  const auto mug = testing::draw_mug();
  const FovealView view = foveal_view(mug.image, mug.mask);
  const Eigen::Vector2d image_px(301.25, 187.5);
  EXPECT_LT((view.image_from_view(view.view_from_image(image_px)) - image_px).norm(), 1e-9);
  // The corner of the printed square (230, 170) lies where the mapping says.
  const Eigen::Vector2d corner = view.view_from_image({230, 170});
  const auto at = [&](double du, double dv) {
    return view.image.at<cv::Vec3b>(static_cast<int>(std::lround(corner.y() + dv)),
                                    static_cast<int>(std::lround(corner.x() + du)));
  };
  EXPECT_EQ(at(4, 4), cv::Vec3b(40, 150, 90));
  EXPECT_EQ(at(-4, 4), cv::Vec3b(60, 80, 150));
  EXPECT_EQ(at(4, -4), cv::Vec3b(60, 80, 150));
}

TEST(Fovea, APairIsFixatedAndStaysRectified) {
  constexpr int disparity_px = 37;
  const cv::Mat texture = testing::random_texture({640 + disparity_px, 480}, 5);
  RectifiedPair pair{texture(cv::Rect(0, 0, 640, 480)).clone(),
                     texture(cv::Rect(disparity_px, 0, 640, 480)).clone()};
  cv::Mat mask = cv::Mat::zeros(480, 640, CV_8UC1);
  cv::rectangle(mask, {200, 150, 120, 90}, cv::Scalar(255), cv::FILLED);
  const cv::Mat disparity(480, 640, CV_32FC1, cv::Scalar(disparity_px));
  const auto fovea = foveal_pair(pair, mask, disparity);
  ASSERT_TRUE(fovea);
  EXPECT_DOUBLE_EQ(fovea->fixation_disparity_px, disparity_px);
  EXPECT_LE(cv::norm(fovea->left.image, fovea->right.image, cv::NORM_INF), 1);  // zero disparity
  EXPECT_EQ(cv::norm(fovea->left.mask, fovea->right.mask, cv::NORM_INF), 0);
}

TEST(Fovea, NoDisparityIsNoPair) {
  const auto mug = testing::draw_mug();
  const cv::Mat unknown(mug.image.size(), CV_32FC1, cv::Scalar(std::nanf("")));
  EXPECT_FALSE(foveal_pair({mug.image, mug.image}, mug.mask, unknown));
}

TEST(Fovea, RefusesBadInput) {
  const auto mug = testing::draw_mug();
  EXPECT_THROW(foveal_view(mug.image, cv::Mat::zeros(480, 640, CV_8UC1)), InvalidInput);
  EXPECT_THROW(foveal_view(mug.image, cv::Mat::ones(48, 64, CV_8UC1)), InvalidInput);
  EXPECT_THROW(foveal_view(cv::Mat(), mug.mask), InvalidInput);
  EXPECT_THROW(foveal_pair({mug.image, mug.image}, mug.mask, cv::Mat(480, 640, CV_16SC1)), InvalidInput);
  FoveaOptions options;
  options.object_px = 0;
  EXPECT_THROW(foveal_view(mug.image, mug.mask, options), InvalidInput);
}

}  // namespace
}  // namespace graspctx
