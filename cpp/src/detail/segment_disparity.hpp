#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace graspctx::detail {

/// Median disparity (px) of a segment in a square window around a pixel; NaN if the window holds none.
/// mask CV_8UC1, > 0 = segment; disparity CV_32FC1, NaN where unknown.
double median_disparity(const cv::Mat& mask, const cv::Mat& disparity, const Eigen::Vector2d& at_px,
                        int half_px);

/// Of the whole segment.
double median_disparity(const cv::Mat& mask, const cv::Mat& disparity);

}  // namespace graspctx::detail
