#include "detail/relief.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "detail/plane_geometry.hpp"
#include "detail/sgbm.hpp"
#include "detail/texture.hpp"

namespace graspctx::detail {

namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
constexpr int border_px = 4;  // windows reach this far over the right view's sides

cv::Mat horizontal_gradient(const cv::Mat& image) {
  cv::Mat gradient;
  cv::filter2D(image, gradient, CV_32F, cv::Matx13f(-0.5F, 0, 0.5F), {-1, -1}, 0, cv::BORDER_REPLICATE);
  return gradient;
}

/// The channel whose noise stands for all: green, or grey itself.
double channel_noise(const cv::Mat& image) {
  if (image.channels() == 1) return noise_sigma(image);
  cv::Mat green;
  cv::extractChannel(image, green, 1);
  return noise_sigma(green);
}

/// Cameras differ in gain: scale the right view so that what is table is as bright in both.
void match_brightness(const cv::Mat& on_table, const cv::Mat& table_view, Relief& relief) {
  const cv::Scalar left = cv::mean(relief.left, on_table), right = cv::mean(table_view, on_table);
  cv::Scalar gain;
  constexpr double most = 1.5;
  for (int c = 0; c < 4; ++c) gain[c] = right[c] > 1 ? std::clamp(left[c] / right[c], 1 / most, most) : 1;
  cv::multiply(relief.right, gain, relief.right);
}

/// Moves each residual to where the views agree best in a small window: Gauss–Newton on colour differences,
/// as Lucas and Kanade do. The window is small: a pencil is only a few pixels wide.
void refine_to_a_fraction(const TablePlane& plane, Relief& relief) {
  constexpr int iterations = 2;
  constexpr float longest_step_px = 0.75F;
  const cv::Size window(5, 5), size = relief.left.size();
  const int values = window.area() * relief.left.channels();
  const auto noise_variance = static_cast<float>(relief.noise * relief.noise);
  const cv::Mat left_gradient = horizontal_gradient(relief.left);
  cv::Mat energy, slope;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const cv::Mat warped = right_view_over_plane(relief.right, plane, relief.residual_px);
    const cv::Mat gradient = 0.5 * (left_gradient + horizontal_gradient(warped));
    cv::boxFilter(channel_sum(gradient.mul(gradient)), energy, CV_32F, window, {-1, -1}, false);
    // left(u) - right(u - d) grows by the gradient times the step when d grows by the step.
    cv::boxFilter(channel_sum(gradient.mul(warped - relief.left)), slope, CV_32F, window, {-1, -1}, false);
    const float damping = static_cast<float>(values) * noise_variance;
    for (int v = 0; v < size.height; ++v) {
      auto* residual = relief.residual_px.ptr<float>(v);
      const auto* s = slope.ptr<float>(v);
      const auto* e = energy.ptr<float>(v);
      for (int u = 0; u < size.width; ++u) {
        residual[u] += std::clamp(s[u] / (e[u] + damping), -longest_step_px, longest_step_px);
      }
    }
  }
  // Both views bring noise to the differences, and to the gradient a part that shows nothing.
  const float noise_energy = static_cast<float>(values) * noise_variance / 4;
  relief.sigma_px.create(size, CV_32FC1);
  for (int v = 0; v < size.height; ++v) {
    const auto* e = energy.ptr<float>(v);
    for (int u = 0; u < size.width; ++u) {
      const float texture = std::max(e[u] - noise_energy, 1e-3F);
      relief.sigma_px.at<float>(v, u) = std::sqrt(2 * noise_variance / texture);
    }
  }
}

/// Forgets the residuals with which the two views still differ: a wrong match leaves a difference as large as
/// the texture itself.
void forget_what_does_not_fit(const TablePlane& plane, Relief& relief) {
  constexpr double most_of_variance = 0.25;
  const cv::Size window(7, 7);
  const cv::Mat difference = relief.left - right_view_over_plane(relief.right, plane, relief.residual_px);
  cv::Mat misfit, square, mean;
  cv::boxFilter(channel_sum(difference.mul(difference)), misfit, CV_32F, window);
  cv::boxFilter(channel_sum(relief.left.mul(relief.left)), square, CV_32F, window);
  cv::boxFilter(relief.left, mean, CV_32F, window);
  const cv::Mat variance = square - channel_sum(mean.mul(mean));
  const double noise_misfit = 4 * relief.noise * relief.noise * relief.left.channels();
  relief.residual_px.setTo(unknown, misfit > most_of_variance * variance + noise_misfit);
}

}  // namespace

cv::Mat channel_sum(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat sum;
  cv::transform(image, sum, cv::Matx13f(1, 1, 1));
  return sum;
}

cv::Mat right_view_over_plane(const cv::Mat& right, const TablePlane& plane, const cv::Mat& residual_px) {
  cv::Mat map_u(right.size(), CV_32FC1), map_v(right.size(), CV_32FC1), view;
  for (int v = 0; v < right.rows; ++v) {
    const auto* residual = residual_px.ptr<float>(v);
    auto* to_u = map_u.ptr<float>(v);
    for (int u = 0; u < right.cols; ++u) {
      const float r = std::isnan(residual[u]) ? 0 : residual[u];
      to_u[u] = static_cast<float>(u - plane_disparity(plane, u, v)) - r;
    }
    map_v.row(v).setTo(v);
  }
  cv::remap(right, view, map_u, map_v, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return view;
}

Relief relief_over_plane(const RectifiedPair& pair, const Disparity& disparity, const TablePlane& plane) {
  const cv::Size size = pair.left.size();
  Relief relief;
  pair.left.convertTo(relief.left, CV_32F);
  pair.right.convertTo(relief.right, CV_32F);
  relief.noise = channel_noise(pair.left);

  cv::Mat on_table(size, CV_8UC1), coarse(size, CV_32FC1);
  relief.inside.create(size, CV_8UC1);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const double on_plane = plane_disparity(plane, u, v), u_right = u - on_plane;
      const bool inside = u_right >= border_px && u_right <= size.width - 1 - border_px;
      const float r = disparity.reliable.at<float>(v, u) - static_cast<float>(on_plane);
      coarse.at<float>(v, u) = r;
      relief.inside.at<uchar>(v, u) = inside ? 255 : 0;
      on_table.at<uchar>(v, u) = inside && std::abs(r) < 1 ? 255 : 0;
    }
  }
  const cv::Mat flat = cv::Mat::zeros(size, CV_32FC1);
  match_brightness(on_table, right_view_over_plane(relief.right, plane, flat), relief);
  cv::Mat table_view;
  right_view_over_plane(relief.right, plane, flat).convertTo(table_view, CV_8U);

  constexpr int lowest_px = -4, range = 32;
  MatcherSettings settings;
  settings.min_disparity_px = lowest_px;
  settings.disparities = range;
  const cv::Mat left_fine = match_semi_global(pair.left, table_view, settings);
  const cv::Mat right_fine = match_semi_global_right(pair.left, table_view, settings);
  cv::Mat fine = keep_consistent(left_fine, right_fine, 1.0);
  constexpr double texture_sigmas = 1.5;
  fine.setTo(unknown, ~horizontal_texture(grey(pair.left), texture_sigmas));

  // The warp stretches rows by 1 - alpha: a disparity s there is one of s·(1 - alpha) here.
  const auto stretch = static_cast<float>(1 - plane.alpha);
  constexpr float top_px = lowest_px + range - 6;
  relief.residual_px.create(size, CV_32FC1);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const float first_pass = coarse.at<float>(v, u);
      const bool out_of_range = first_pass > top_px || first_pass < lowest_px + 1;
      const float near = relief.inside.at<uchar>(v, u) ? fine.at<float>(v, u) * stretch : unknown;
      relief.residual_px.at<float>(v, u) = out_of_range ? first_pass : near;
    }
  }
  refine_to_a_fraction(plane, relief);
  forget_what_does_not_fit(plane, relief);
  return relief;
}

}  // namespace graspctx::detail
