#include "graspctx/stereo_match.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "detail/check.hpp"

namespace graspctx {

void StereoMatchOptions::check() const {
  detail::require_option(window_px >= 3 && window_px <= 301 && window_px % 2 == 1,
                         "match window_px must be odd, 3 to 301");
  detail::require_option(std::isfinite(search_px) && search_px >= 1 && search_px <= 1000,
                         "match search_px must be 1 to 1000");
  detail::require_option(min_correlation >= -1 && min_correlation <= 1, "min_correlation must be -1 to 1");
}

std::optional<StereoMatch> match_patch(const FovealPair& pair, const Eigen::Vector2d& left_view_px,
                                       double prior_px, const StereoMatchOptions& options) {
  options.check();
  // The foveal pair is fixated: an offset o in the views is the disparity fixation + o / scale.
  const double scale = pair.left.scale;
  const double prior_offset_px =
      std::isfinite(prior_px) ? (prior_px - pair.fixation_disparity_px) * scale : 0.0;
  const double reach_px = std::isfinite(prior_px) ? options.search_px / 2 : options.search_px;

  // Pixels on the object and its very edge are compared: beyond the outline the window shows background,
  // which moves with another disparity.
  constexpr int edge_px = 9;
  const int half = options.window_px / 2;
  const cv::Point centre(static_cast<int>(std::lround(left_view_px.x())),
                         static_cast<int>(std::lround(left_view_px.y())));
  const cv::Rect window(centre.x - half, centre.y - half, options.window_px, options.window_px);
  const cv::Rect view({0, 0}, pair.left.image.size());
  if ((window & view) != window) return std::nullopt;
  cv::Mat weights;
  cv::dilate(pair.left.mask(window), weights,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {edge_px, edge_px}));
  const int least_px = options.window_px * options.window_px / 8;
  const bool masked = cv::countNonZero(weights) >= least_px;

  // Whole offsets, plus one either side for the parabola.
  const int first = static_cast<int>(std::floor(prior_offset_px - reach_px)) - 1;
  const int last = static_cast<int>(std::ceil(prior_offset_px + reach_px)) + 1;
  const int search_left = std::max(0, window.x - last),
            search_right = std::min(view.width, window.br().x - first);
  if (search_right - search_left < options.window_px + 2) return std::nullopt;
  const cv::Rect strip(search_left, window.y, search_right - search_left, window.height);
  cv::Mat correlation;
  cv::matchTemplate(pair.right.image(strip), pair.left.image(window), correlation, cv::TM_CCOEFF_NORMED,
                    masked ? weights : cv::noArray());
  cv::patchNaNs(correlation, -1.0);

  // matchTemplate divides by the spread of the pixels: without any it gives infinity or more than one.
  int best = -1;
  float best_value = -2;
  for (int i = 0; i < correlation.cols; ++i) {
    const float value = correlation.at<float>(0, i);
    if (std::isfinite(value) && value <= 1.001f && value > best_value) {
      best = i;
      best_value = value;
    }
  }
  if (best <= 0 || best >= correlation.cols - 1 || best_value < options.min_correlation) return std::nullopt;

  const double before = correlation.at<float>(0, best - 1), at = best_value,
               after = correlation.at<float>(0, best + 1);
  const double curvature = before - 2 * at + after;  // negative at a maximum
  if (!(curvature < 0)) return std::nullopt;
  const double sub_pixel = std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);

  StereoMatch match;
  match.left_view_px = left_view_px;
  const double offset_px = window.x - (search_left + best + sub_pixel);
  match.right_view_px = left_view_px - Eigen::Vector2d(offset_px, 0);
  match.disparity_px = pair.fixation_disparity_px + offset_px / scale;
  match.correlation = at;
  // Cramér–Rao: noise variance over signal curvature, both read off the correlation itself.
  const double samples = masked ? cv::countNonZero(weights) : window.area();
  match.disparity_stddev_px =
      std::max(0.05, std::sqrt(std::max(1e-4, 1 - at * at) / (-curvature * samples / 9.0))) / scale;
  return match;
}

}  // namespace graspctx
