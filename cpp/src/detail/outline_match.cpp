#include "detail/outline_match.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "detail/relief.hpp"
#include "detail/texture.hpp"

namespace graspctx::detail {

namespace {

constexpr int beyond_px = 2;  // of the edge's peak, what belongs to the edge
constexpr int inside_px = 7;  // on the region's side
constexpr int half_rows = 3;
constexpr int width_px = inside_px + beyond_px + 1;
constexpr double window_px = width_px * (2 * half_rows + 1);

/// Both views, a little smoothed: noise of single pixels says nothing here.
struct Views {
  cv::Mat left, right;  // CV_32FC1 or CV_32FC3
  cv::Mat slope;        // CV_32FC1: squared horizontal gradient of the left view, over the channels
  double noise = 1;     // of one channel after smoothing

  explicit Views(const RectifiedPair& pair) {
    constexpr double blur_px = 0.7;
    const double averaged = 2 * std::sqrt(CV_PI) * blur_px;
    noise = noise_sigma(grey(pair.left)) * std::sqrt(pair.left.channels()) / averaged;
    pair.left.convertTo(left, CV_32F);
    pair.right.convertTo(right, CV_32F);
    cv::GaussianBlur(left, left, {0, 0}, blur_px);
    cv::GaussianBlur(right, right, {0, 0}, blur_px);
    cv::Mat gradient;
    cv::filter2D(left, gradient, CV_32F, cv::Matx13f(-0.5F, 0, 0.5F), {-1, -1}, 0, cv::BORDER_REPLICATE);
    slope = channel_sum(gradient.mul(gradient));
  }
  int channels() const { return left.channels(); }
};

/// The first edge met from where a region ends at u, going in a direction (±1); nothing if there is none
/// near.
std::optional<int> edge_at(const Views& views, int u, int v, int direction) {
  constexpr int farthest_px = 7;
  constexpr double least_sigmas = 4;
  const auto* slope = views.slope.ptr<float>(v);
  const double least = least_sigmas * least_sigmas * views.noise * views.noise / 2;
  for (int k = -1; k <= farthest_px; ++k) {
    const int at = u + direction * k;
    if (at < inside_px + 1 || at >= views.left.cols - inside_px - 1) return std::nullopt;
    if (slope[at] >= least && slope[at] >= slope[at - 1] && slope[at] >= slope[at + 1]) return at;
  }
  return std::nullopt;
}

/// What is compared: the pixels of a window on the region's side of the edge, as rows of values.
struct Window {
  int first_u, first_v;
};

/// The sum over channels of the variance of what a function gives for each value of the window.
template <typename Value>
double variance(const Views& views, const Window& window, const Value& value) {
  const int channels = views.channels();
  double square = 0, sums[4] = {};
  for (int row = 0; row <= 2 * half_rows; ++row) {
    const auto v = window.first_v + row;
    const auto* left = views.left.ptr<float>(v) + window.first_u * channels;
    const auto* right = views.right.ptr<float>(v) + window.first_u * channels;
    for (int i = 0; i < width_px * channels; ++i) {
      const double d = value(left + i, right + i);
      square += d * d;
      sums[i % channels] += d;
    }
  }
  for (int c = 0; c < channels; ++c) square -= sums[c] * sums[c] / window_px;
  return square / window_px;
}

/// The disparity of whole pixels that fits much better than any other but its neighbours.
std::optional<int> unique_disparity(const Views& views, const Window& window, int most) {
  const int channels = views.channels();
  std::vector<double> differences;
  const int last = std::min(most, window.first_u - 1);
  for (int d = 0; d <= last; ++d) {
    differences.push_back(variance(views, window, [&](const float* left, const float* right) {
      return double(*left - *(right - d * channels));
    }));
  }
  if (differences.size() < 3) return std::nullopt;
  const auto best = std::min_element(differences.begin(), differences.end());
  const double floor = 2 * views.noise * views.noise * channels;
  constexpr double least_ratio = 1.5;
  constexpr int neighbours_px = 3;
  for (auto rival = differences.begin() + 1; rival + 1 < differences.end(); ++rival) {
    const bool is_valley = *rival <= *(rival - 1) && *rival <= *(rival + 1);
    if (!is_valley || std::abs(rival - best) <= neighbours_px) continue;
    if (*rival < least_ratio * std::max(*best, floor)) return std::nullopt;
  }
  return static_cast<int>(best - differences.begin());
}

/// Gauss–Newton from there to a fraction of a pixel.
std::optional<OutlineMatch> refined(const Views& views, const Window& window, int start) {
  const int channels = views.channels();
  double disparity = start;
  double misfit = 0;
  OutlineMatch match{0, 0, 0, 0};
  for (int iteration = 0; iteration < 6; ++iteration) {
    const double shift = std::floor(-disparity);
    const auto whole = static_cast<int>(shift);
    const auto part = static_cast<float>(-disparity - shift);
    if (window.first_u + whole < 1 || window.first_u + width_px + whole + 2 > views.left.cols)
      return std::nullopt;
    double gg = 0, gd = 0, dd = 0, weight_u = 0, weight_v = 0, g_sum[4] = {}, d_sum[4] = {};
    for (int row = 0; row <= 2 * half_rows; ++row) {
      const auto* left = views.left.ptr<float>(window.first_v + row) + window.first_u * channels;
      const auto* right = views.right.ptr<float>(window.first_v + row) + (window.first_u + whole) * channels;
      const auto at = [&](int i) { return right[i] + part * (right[i + channels] - right[i]); };
      for (int i = 0; i < width_px * channels; ++i) {
        const double g =
            0.25 * (left[i + channels] - left[i - channels] + at(i + channels) - at(i - channels));
        const double d = left[i] - at(i);
        const int c = i % channels;
        gg += g * g;
        gd += g * d;
        dd += d * d;
        g_sum[c] += g;
        d_sum[c] += d;
        weight_u += g * g * (i / channels);
        weight_v += g * g * row;
      }
    }
    if (gg <= 0) return std::nullopt;
    match.u = window.first_u + weight_u / gg;
    match.v = window.first_v + weight_v / gg;
    for (int c = 0; c < channels; ++c) {
      gg -= g_sum[c] * g_sum[c] / window_px;
      gd -= g_sum[c] * d_sum[c] / window_px;
      dd -= d_sum[c] * d_sum[c] / window_px;
    }
    if (gg < 1e-3) return std::nullopt;
    match.sigma_px = views.noise * std::sqrt(2 / gg);
    // left(u) - right(u - d) grows by the gradient times the step when d grows by the step.
    misfit = dd / window_px;
    const double step = std::clamp(-gd / gg, -0.75, 0.75);
    disparity += step;
    constexpr double enough_px = 0.005;
    if (std::abs(step) < enough_px) break;
  }
  if (std::abs(disparity - start) > 1.5) return std::nullopt;
  // A wrong match leaves a difference as large as the edge itself.
  const double contrast =
      variance(views, window, [](const float* left, const float*) { return double(*left); });
  if (misfit > 0.05 * contrast + 4 * views.noise * views.noise * channels) return std::nullopt;
  match.disparity_px = disparity;
  return match;
}

}  // namespace

std::vector<OutlineMatch> match_outline(const RectifiedPair& pair, const cv::Mat& region, int most_px) {
  const Views views(pair);
  constexpr double most_sigma_px = 0.3;
  std::vector<OutlineMatch> matches;
  for (int v = half_rows; v + half_rows < region.rows; ++v) {
    const auto* row = region.ptr<uchar>(v);
    for (int u = 1; u < region.cols; ++u) {
      if ((row[u] != 0) == (row[u - 1] != 0)) continue;
      const int direction = row[u - 1] ? 1 : -1;  // out of the region
      const auto edge = edge_at(views, row[u - 1] ? u - 1 : u, v, direction);
      if (!edge) continue;
      const Window window{direction > 0 ? *edge - inside_px : *edge - beyond_px, v - half_rows};
      const auto coarse = unique_disparity(views, window, most_px);
      if (!coarse) continue;
      const auto match = refined(views, window, *coarse);
      if (match && match->sigma_px < most_sigma_px) matches.push_back(*match);
    }
  }
  return matches;
}

}  // namespace graspctx::detail
