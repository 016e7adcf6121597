#pragma once
#include <opencv2/core.hpp>
#include <vector>

namespace graspctx::detail {

/// Masks are CV_8UC1, > 0 inside; results hold 255.
cv::Mat grown(const cv::Mat& mask, int by_px);
cv::Mat shrunk(const cv::Mat& mask, int by_px);
cv::Mat convex_hull(const cv::Mat& mask);

/// Every pixel inside, row by row.
std::vector<cv::Point> where(const cv::Mat& mask);

/// The connected parts of a mask that hold at least `least` pixels of another.
cv::Mat parts_holding(const cv::Mat& mask, const cv::Mat& other, int least);

/// The connected parts of a mask that hold more than a fifth of what the richest part holds of the seeds.
cv::Mat parts_with_seeds(const cv::Mat& mask, const cv::Mat& seeds);

}  // namespace graspctx::detail
