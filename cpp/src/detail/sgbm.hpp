#pragma once
#include <opencv2/core.hpp>

namespace graspctx::detail {

struct MatcherSettings {
  int min_disparity_px = 0;
  int disparities = 16;  // a multiple of 16
  int block_px = 5;
  int small_step = 8, large_step = 32;  // price of a disparity that differs by 1 px, and by more
  int gradient_cap = 15;                // grey levels; larger gradients count as much
  double uniqueness_percent = 10;
  int speckle_px = 50;
};

/// SGBM of a pair whose sides are padded by the search range, so that every column is searched. CV_32FC1 px,
/// NaN where unknown or where the match would lie outside the right view. left and right may be the same
/// region of two larger images: the search then goes on in these.
cv::Mat match_semi_global(const cv::Mat& left, const cv::Mat& right, const MatcherSettings& settings);

/// The right view's disparity (as positive as the left's) by the same matcher on the mirrored pair.
cv::Mat match_semi_global_right(const cv::Mat& left, const cv::Mat& right, const MatcherSettings& settings);

/// What of the left view's disparity the right view's own disparity confirms; NaN elsewhere.
cv::Mat keep_consistent(const cv::Mat& left_disparity, const cv::Mat& right_disparity, double tolerance_px);

}  // namespace graspctx::detail
