#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>
#include <vector>

#include "detail/superpixels.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using detail::find_superpixels;
using detail::Superpixels;

constexpr int least_px = 20;

/// Plain rectangles on a plain ground, and which of them each pixel is of.
struct Picture {
  cv::Mat image{160, 200, CV_8UC3, cv::Scalar(180, 180, 170)};
  cv::Mat truth = cv::Mat::zeros(160, 200, CV_8UC1);
};

Picture rectangles() {
  Picture picture;
  const std::vector<std::pair<cv::Rect, cv::Scalar>> drawn{{{10, 12, 60, 40}, {60, 80, 150}},
                                                           {{70, 12, 50, 70}, {40, 170, 60}},
                                                           {{30, 90, 90, 50}, {200, 60, 40}},
                                                           {{150, 0, 50, 160}, {20, 20, 20}},
                                                           {{60, 100, 30, 30}, {60, 200, 230}}};
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    picture.image(drawn[i].first).setTo(drawn[i].second);
    picture.truth(drawn[i].first).setTo(static_cast<double>(i) + 1);
  }
  return picture;
}

cv::Mat noisy_texture(const cv::Size& size = {200, 160}) {
  RectifiedPair pair{testing::random_texture(size, 5, 9), testing::random_texture(size, 6, 9)};
  testing::add_noise(pair, 4);
  return pair.left;
}

std::vector<int> sizes(const Superpixels& superpixels) {
  std::vector<int> result(static_cast<std::size_t>(superpixels.count), 0);
  for (const int label : cv::Mat_<int>(superpixels.labels)) ++result.at(static_cast<std::size_t>(label));
  return result;
}

TEST(Superpixels, DoNotCrossTheOutlinesOfPlainRectangles) {
  const Picture picture = rectangles();
  const Superpixels found = find_superpixels(picture.image);
  std::set<std::pair<int, int>> pieces;  // label, true rectangle
  for (int v = 0; v < picture.truth.rows; ++v) {
    for (int u = 0; u < picture.truth.cols; ++u) {
      pieces.emplace(found.labels.at<int>(v, u), picture.truth.at<uchar>(v, u));
    }
  }
  EXPECT_EQ(static_cast<int>(pieces.size()), found.count);  // each label in one rectangle
}

TEST(Superpixels, APlainRectangleIsOneButForItsBlurredOutline) {
  const Picture picture = rectangles();
  const Superpixels found = find_superpixels(picture.image);
  for (int id = 0; id <= 5; ++id) {
    cv::Mat inside;
    cv::erode(picture.truth == id, inside, cv::Mat::ones(9, 9, CV_8UC1));
    std::set<int> labels;
    for (int v = 0; v < inside.rows; ++v) {
      for (int u = 0; u < inside.cols; ++u) {
        if (inside.at<uchar>(v, u)) labels.insert(found.labels.at<int>(v, u));
      }
    }
    EXPECT_EQ(labels.size(), 1u) << id;
  }
}

TEST(Superpixels, AreNumberedConnectedAndNotSmall) {
  for (const cv::Mat& image :
       {rectangles().image, noisy_texture(), testing::random_texture({90, 70}, 3, 1)}) {
    const Superpixels found = find_superpixels(image);
    ASSERT_EQ(found.labels.type(), CV_32SC1);
    ASSERT_EQ(found.labels.size(), image.size());
    double least = 0, most = 0;
    cv::minMaxLoc(found.labels, &least, &most);
    EXPECT_EQ(least, 0);
    EXPECT_EQ(most, found.count - 1);
    EXPECT_GT(found.count, 1);
    for (const int size : sizes(found)) EXPECT_GE(size, least_px);
    for (int label = 0; label < found.count; ++label) {
      cv::Mat parts;
      EXPECT_EQ(cv::connectedComponents(found.labels == label, parts, 8), 2) << label;  // and the rest
    }
  }
}

TEST(Superpixels, AreNumberedInTheOrderOfTheirFirstPixels) {
  const Superpixels found = find_superpixels(noisy_texture());
  int next = 0;
  for (const int label : cv::Mat_<int>(found.labels)) {
    ASSERT_LE(label, next);
    if (label == next) ++next;
  }
}

TEST(Superpixels, OfAPictureThatIsSmallOrPlainIsOne) {
  EXPECT_EQ(find_superpixels(testing::random_texture({5, 3}, 1, 1)).count, 1);
  EXPECT_EQ(find_superpixels(cv::Mat(1, 1, CV_8UC3, cv::Scalar(1, 2, 3))).count, 1);
  EXPECT_EQ(find_superpixels(cv::Mat(80, 100, CV_8UC1, cv::Scalar(77))).count, 1);
}

TEST(Superpixels, OfAGreyPictureAreThoseOfItsColourCopy) {
  cv::Mat grey, copy;
  cv::cvtColor(noisy_texture(), grey, cv::COLOR_BGR2GRAY);
  cv::cvtColor(grey, copy, cv::COLOR_GRAY2BGR);
  const Superpixels a = find_superpixels(grey), b = find_superpixels(copy);
  EXPECT_EQ(a.count, b.count);
  EXPECT_GT(a.count, 10);
  EXPECT_EQ(cv::countNonZero(a.labels != b.labels), 0);
}

TEST(Superpixels, OfAMirroredPictureAreAboutAsMany) {
  const cv::Mat image = noisy_texture();
  const int count = find_superpixels(image).count;
  for (const int axis : {0, 1, -1}) {
    cv::Mat mirrored;
    cv::flip(image, mirrored, axis);
    EXPECT_NEAR(find_superpixels(mirrored).count, count, 0.1 * count);
  }
}

TEST(Superpixels, DoNotDependOnWhatLiesAroundAPartOfAnImage) {
  cv::Mat image = noisy_texture({200, 160});
  const cv::Mat part = image(cv::Rect(40, 30, 100, 90));
  const Superpixels a = find_superpixels(part), b = find_superpixels(part.clone());
  EXPECT_EQ(cv::countNonZero(a.labels != b.labels), 0);
}

}  // namespace
}  // namespace graspctx
