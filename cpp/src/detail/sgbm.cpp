#include "detail/sgbm.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace graspctx::detail {

namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

cv::Mat mirrored(const cv::Mat& image) {
  cv::Mat flipped;
  cv::flip(image, flipped, 1);
  return flipped;
}

}  // namespace

cv::Mat match_semi_global(const cv::Mat& left, const cv::Mat& right, const MatcherSettings& settings) {
  const int pad_left = std::max(0, settings.min_disparity_px + settings.disparities);
  const int pad_right = std::max(0, -settings.min_disparity_px);
  cv::Mat padded_left, padded_right, fixed_point;
  cv::copyMakeBorder(left, padded_left, 0, 0, pad_left, pad_right, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(right, padded_right, 0, 0, pad_left, pad_right, cv::BORDER_REPLICATE);
  const int unit = settings.block_px * settings.block_px * left.channels();
  constexpr int like_disparity_px = 2;
  const auto matcher = cv::StereoSGBM::create(
      settings.min_disparity_px, settings.disparities, settings.block_px, settings.small_step * unit,
      settings.large_step * unit, -1, settings.gradient_cap,
      static_cast<int>(std::lround(settings.uniqueness_percent)), settings.speckle_px, like_disparity_px,
      cv::StereoSGBM::MODE_SGBM_3WAY);
  matcher->compute(padded_left, padded_right, fixed_point);

  cv::Size whole;
  cv::Point at;
  right.locateROI(whole, at);
  const int invalid = (settings.min_disparity_px - 1) * cv::StereoMatcher::DISP_SCALE;
  cv::Mat disparity(left.size(), CV_32FC1);
  for (int v = 0; v < left.rows; ++v) {
    const auto* from = fixed_point.ptr<std::int16_t>(v) + pad_left;
    auto* to = disparity.ptr<float>(v);
    for (int u = 0; u < left.cols; ++u) {
      const float value = static_cast<float>(from[u]) / cv::StereoMatcher::DISP_SCALE;
      const float u_right = static_cast<float>(at.x + u) - value;
      const bool inside = u_right >= -0.5F && u_right <= static_cast<float>(whole.width) - 0.5F;
      to[u] = from[u] > invalid && inside ? value : unknown;
    }
  }
  return disparity;
}

cv::Mat match_semi_global_right(const cv::Mat& left, const cv::Mat& right, const MatcherSettings& settings) {
  return mirrored(match_semi_global(mirrored(right), mirrored(left), settings));
}

cv::Mat keep_consistent(const cv::Mat& left_disparity, const cv::Mat& right_disparity, double tolerance_px) {
  cv::Mat kept(left_disparity.size(), CV_32FC1, cv::Scalar(unknown));
  for (int v = 0; v < kept.rows; ++v) {
    const auto* left = left_disparity.ptr<float>(v);
    const auto* right = right_disparity.ptr<float>(v);
    auto* to = kept.ptr<float>(v);
    for (int u = 0; u < kept.cols; ++u) {
      if (std::isnan(left[u])) continue;
      const int u_right = static_cast<int>(std::lround(static_cast<float>(u) - left[u]));
      if (u_right < 0 || u_right >= kept.cols) continue;
      if (std::abs(right[u_right] - left[u]) <= tolerance_px) to[u] = left[u];
    }
  }
  return kept;
}

}  // namespace graspctx::detail
