#include "graspctx/stereo.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "detail/check.hpp"
#include "detail/quantile.hpp"
#include "detail/scene_checks.hpp"
#include "detail/sgbm.hpp"
#include "detail/texture.hpp"
#include "graspctx/error.hpp"

namespace graspctx {

namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
constexpr int smallest_side_px = 16;
constexpr int most_disparities = 2032;  // SGBM counts sixteenths of a pixel in 16 bits

void require_pair(const cv::Mat& left, const cv::Mat& right) {
  detail::require_image(left, "left image");
  detail::require_image(right, "right image");
  if (left.size() != right.size() || left.type() != right.type()) {
    throw InvalidInput("stereo pair: expected two images of the same size and type, got left " +
                       detail::describe(left) + " and right " + detail::describe(right));
  }
  if (left.cols < smallest_side_px || left.rows < smallest_side_px) {
    throw InvalidInput("stereo pair: expected images of at least 16x16 px, got " + detail::describe(left));
  }
}

cv::Mat as_cv(const Eigen::Matrix3d& matrix) {
  cv::Mat converted(3, 3, CV_64F);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) converted.at<double>(row, column) = matrix(row, column);
  }
  return converted;
}

cv::Mat rectify_view(const cv::Mat& image, const RawView& view, const Eigen::Matrix3d& rectified) {
  const cv::Mat distortion = cv::Mat(view.distortion, true);
  cv::Mat map_x, map_y, result;
  if (view.distortion_model == RawView::Distortion::plumb_bob) {
    cv::initUndistortRectifyMap(as_cv(view.camera_matrix), distortion, as_cv(view.rectified_from_raw),
                                as_cv(rectified), image.size(), CV_32FC1, map_x, map_y);
  } else {
    cv::fisheye::initUndistortRectifyMap(as_cv(view.camera_matrix), distortion,
                                         as_cv(view.rectified_from_raw), as_cv(rectified), image.size(),
                                         CV_32FC1, map_x, map_y);
  }
  cv::remap(image, result, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return result;
}

detail::MatcherSettings matcher_settings(const DisparityOptions& options, int min_disparity_px,
                                         int disparities) {
  detail::MatcherSettings settings;
  settings.min_disparity_px = min_disparity_px;
  settings.disparities = disparities;
  settings.block_px = options.block_px;
  // A low cap cuts off what a fraction of a pixel is told from.
  settings.gradient_cap = 63;
  settings.small_step = 4;
  settings.large_step = 24;
  settings.uniqueness_percent = options.uniqueness_percent;
  settings.speckle_px = options.speckle_px;
  return settings;
}

/// Brings a disparity map to another image size. Interpolates within a surface, never across a depth step.
cv::Mat enlarge(const cv::Mat& small, const cv::Size& size) {
  const double scale_u = static_cast<double>(size.width) / small.cols;
  const double scale_v = static_cast<double>(size.height) / small.rows;
  constexpr float largest_step_px = 1;
  cv::Mat large(size, CV_32FC1);
  for (int v = 0; v < size.height; ++v) {
    const double y = std::clamp((v + 0.5) / scale_v - 0.5, 0.0, small.rows - 1.0);
    const int y0 = static_cast<int>(y), y1 = std::min(y0 + 1, small.rows - 1);
    const auto fy = static_cast<float>(y - y0);
    const auto* top = small.ptr<float>(y0);
    const auto* bottom = small.ptr<float>(y1);
    auto* to = large.ptr<float>(v);
    for (int u = 0; u < size.width; ++u) {
      const double x = std::clamp((u + 0.5) / scale_u - 0.5, 0.0, small.cols - 1.0);
      const int x0 = static_cast<int>(x), x1 = std::min(x0 + 1, small.cols - 1);
      const auto fx = static_cast<float>(x - x0);
      const float a = top[x0], b = top[x1], c = bottom[x0], d = bottom[x1];
      const float step = std::max({a, b, c, d}) - std::min({a, b, c, d});
      const bool one_surface = !std::isnan(a + b + c + d) && step <= largest_step_px;
      const float value = one_surface ? (1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d)
                                      : small.at<float>(fy < 0.5F ? y0 : y1, fx < 0.5F ? x0 : x1);
      to[u] = value * static_cast<float>(scale_u);
    }
  }
  return large;
}

std::map<int, cv::Rect> boxes_of_instances(const cv::Mat& instance_ids) {
  std::map<int, cv::Rect> boxes;
  for (int v = 0; v < instance_ids.rows; ++v) {
    for (int u = 0; u < instance_ids.cols; ++u) {
      if (const int id = instance_ids.at<uchar>(v, u)) boxes[id] |= cv::Rect(u, v, 1, 1);
    }
  }
  return boxes;
}

/// Matches the surroundings of an object at full resolution, within the disparities that are found there.
void refine_region(const RectifiedPair& pair, const Disparity& coarse, const cv::Mat& instance_ids, int id,
                   const cv::Rect& box, const DisparityOptions& options, Disparity& refined) {
  constexpr int margin_px = 12, beyond_px = 4, most_range_px = 256;
  constexpr float agreeing_px = 2;  // a pixel of the coarse map
  const cv::Rect region =
      cv::Rect(box.x - margin_px, box.y - margin_px, box.width + 2 * margin_px, box.height + 2 * margin_px) &
      cv::Rect({0, 0}, pair.left.size());
  std::vector<float> known;
  for (int v = region.y; v < region.br().y; ++v) {
    const auto* row = coarse.dense.ptr<float>(v);
    std::copy_if(row + region.x, row + region.br().x, std::back_inserter(known),
                 [](float px) { return !std::isnan(px); });
  }
  if (known.empty()) return;
  const int lowest = static_cast<int>(std::floor(detail::quantile(known, 0.02))) - beyond_px;
  const int highest = static_cast<int>(std::ceil(detail::quantile(known, 0.98))) + beyond_px;
  const int range = std::min((highest - lowest + 16) / 16 * 16, most_range_px);
  const cv::Mat fine = detail::match_semi_global(pair.left(region), pair.right(region),
                                                 matcher_settings(options, highest + 1 - range, range));
  for (int v = 0; v < region.height; ++v) {
    for (int u = 0; u < region.width; ++u) {
      const cv::Point at(region.x + u, region.y + v);
      if (instance_ids.at<uchar>(at) != id) continue;
      const float px = fine.at<float>(v, u);
      const float before = coarse.dense.at<float>(at);
      const bool contradicts = !std::isnan(before) && std::abs(px - before) > agreeing_px;
      if (std::isnan(px) || contradicts) continue;
      refined.dense.at<float>(at) = px;
      if (!std::isnan(coarse.reliable.at<float>(at))) refined.reliable.at<float>(at) = px;
    }
  }
}

}  // namespace

RectifiedPair rectify(const cv::Mat& left, const cv::Mat& right, const StereoCamera& camera) {
  camera.check();
  require_pair(left, right);
  if ((camera.width_px > 0 && camera.width_px != left.cols) ||
      (camera.height_px > 0 && camera.height_px != left.rows)) {
    throw InvalidInput("stereo pair: the calibration is for images of " + std::to_string(camera.width_px) +
                       "x" + std::to_string(camera.height_px) + " px, got " + detail::describe(left));
  }
  if (!camera.raw) return {left, right};
  Eigen::Matrix3d rectified = Eigen::Matrix3d::Identity();
  rectified(0, 0) = rectified(1, 1) = camera.focal_px;
  rectified.topRightCorner<2, 1>() = camera.centre_px;
  const cv::Mat rectified_left = rectify_view(left, (*camera.raw)[0], rectified);
  rectified(0, 2) += camera.doffs_px;
  return {rectified_left, rectify_view(right, (*camera.raw)[1], rectified)};
}

void DisparityOptions::check() const {
  using detail::require_option;
  const int most_px = half_resolution ? 2 * most_disparities : most_disparities;
  require_option(max_disparity_px >= 0 && max_disparity_px <= most_px,
                 "max_disparity_px must be between 0 and " + std::to_string(most_px) + ", got " +
                     std::to_string(max_disparity_px));
  require_option(block_px >= 1 && block_px <= 21 && block_px % 2 == 1,
                 "block_px must be odd and between 1 and 21, got " + std::to_string(block_px));
  require_option(uniqueness_percent >= 0 && uniqueness_percent < 100,
                 "uniqueness_percent must be in [0, 100), got " + std::to_string(uniqueness_percent));
  require_option(speckle_px >= 0, "speckle_px must not be negative, got " + std::to_string(speckle_px));
  require_option(left_right_px >= 0 && std::isfinite(left_right_px),
                 "left_right_px must be a number >= 0, got " + std::to_string(left_right_px));
  require_option(texture_sigmas >= 0 && std::isfinite(texture_sigmas),
                 "texture_sigmas must be a number >= 0, got " + std::to_string(texture_sigmas));
}

Disparity compute_disparity(const RectifiedPair& pair, const DisparityOptions& options) {
  options.check();
  require_pair(pair.left, pair.right);
  const cv::Size size = pair.left.size();
  cv::Mat left = pair.left, right = pair.right;
  if (options.half_resolution) {
    const cv::Size half((size.width + 1) / 2, (size.height + 1) / 2);
    cv::resize(pair.left, left, half, 0, 0, cv::INTER_AREA);
    cv::resize(pair.right, right, half, 0, 0, cv::INTER_AREA);
  }
  const double shrink = static_cast<double>(left.cols) / size.width;
  const double range_px = options.max_disparity_px > 0 ? options.max_disparity_px : size.width / 4.0;
  const int disparities =
      std::clamp(static_cast<int>(std::ceil(range_px * shrink / 16)) * 16, 16, most_disparities);

  const detail::MatcherSettings settings = matcher_settings(options, 0, disparities);
  const cv::Mat dense = detail::match_semi_global(left, right, settings);
  const cv::Mat right_dense = detail::match_semi_global_right(left, right, settings);
  cv::Mat reliable = detail::keep_consistent(dense, right_dense, options.left_right_px);
  reliable.setTo(unknown, ~detail::horizontal_texture(detail::grey(left), options.texture_sigmas));

  if (left.size() == size) return {dense, reliable};
  return {enlarge(dense, size), enlarge(reliable, size)};
}

Disparity refine_disparity(const RectifiedPair& pair, const Disparity& disparity, const cv::Mat& instance_ids,
                           const DisparityOptions& options) {
  options.check();
  require_pair(pair.left, pair.right);
  detail::require_scene(pair, disparity);
  detail::require_mask(instance_ids, pair.left.size(), "instance mask");
  Disparity refined{disparity.dense.clone(), disparity.reliable.clone()};
  if (!options.half_resolution) return refined;
  for (const auto& [id, box] : boxes_of_instances(instance_ids)) {
    refine_region(pair, disparity, instance_ids, id, box, options, refined);
  }
  return refined;
}

}  // namespace graspctx
