// What lies on a plain table, by colour, on scenes of rectangles.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "detail/plain_table_objects.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

const StereoCamera camera = testing::test_camera();
const cv::Size size(camera.width_px, camera.height_px);
const cv::Scalar bare(120, 120, 120), other(60, 90, 200), faint(135, 135, 135);

cv::Mat rectangle(const cv::Rect& box) {
  cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
  mask(box).setTo(255);
  return mask;
}

/// The table fills the image below v = 100.
detail::PlainTable lower_table(const cv::Mat& not_table) {
  detail::PlainTable table;
  table.extent = rectangle({0, 100, size.width, size.height - 100});
  table.region = table.extent & ~not_table;
  table.colour = cv::Mat(size, CV_32FC3, bare);
  table.sigma = cv::Scalar::all(1);
  return table;
}

std::vector<cv::Mat> found_without_plane(const cv::Mat& not_table, const cv::Scalar& colour) {
  cv::Mat image(size, CV_8UC3, bare);
  image.setTo(colour, not_table);
  Disparity disparity;
  disparity.dense = cv::Mat(size, CV_32FC1, cv::Scalar(60));
  disparity.reliable = disparity.dense;
  return detail::figures_on_plain_table({image, image}, disparity, lower_table(not_table), nullptr, camera,
                                        {});
}

TEST(PlainTableObjects, WhatRunsAlongTheBorderIsBackground) {
  const cv::Mat strip = rectangle({40, 100, 150, 8}), across = rectangle({300, 60, 40, 110});
  cv::Mat image(size, CV_8UC3, bare);
  image.setTo(other, strip | across);
  const detail::PlainTable table = lower_table(strip | across);
  Disparity disparity;
  disparity.dense = cv::Mat(size, CV_32FC1, cv::Scalar(60));
  disparity.reliable = disparity.dense;
  const auto found = detail::figures_on_plain_table({image, image}, disparity, table, nullptr, camera, {});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].at<uchar>(140, 320), 255);
}

TEST(PlainTableObjects, AScrapBesideAFigureIsItsOwn) {
  const cv::Mat bowl = rectangle({200, 200, 60, 40}), rest = rectangle({293, 218, 30, 5});
  const cv::Mat handle = rectangle({263, 218, 27, 5}) | rest;  // seen in two pieces, 3 px apart
  const auto spoon = found_without_plane(bowl | handle, faint);
  ASSERT_EQ(spoon.size(), 1u);
  EXPECT_EQ(spoon[0].at<uchar>(220, 310), 255);
  // Of about the same size they may be two.
  EXPECT_EQ(found_without_plane(bowl | rectangle({263, 200, 40, 40}), faint).size(), 2u);
}

}  // namespace
}  // namespace graspctx
