#include "detail/outline_match.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "detail/relief.hpp"
#include "detail/texture.hpp"

namespace graspctx::detail {

namespace {

// Across the outline a window has so many samples a pixel apart, along rows as far apart as that makes them.
constexpr int beyond_px = 2;  // of the edge's peak, what belongs to the edge
constexpr int inside_px = 7;  // on the region's side
constexpr int half_rows = 3, rows = 2 * half_rows + 1;
constexpr int width = inside_px + beyond_px + 1;
constexpr double window_samples = width * rows;

/// Both views, a little smoothed: noise of single pixels says nothing here.
struct Views {
  cv::Mat left, right;    // CV_32FC1 or CV_32FC3
  cv::Mat steepness;      // CV_32FC1: squared gradient of the left view, over the channels
  cv::Mat across, mixed;  // CV_32FC1: sums of du² and du·dv of the gradient over a window
  double noise = 1;       // of one channel after smoothing

  explicit Views(const RectifiedPair& pair) {
    constexpr double blur_px = 0.7;
    const double averaged = 2 * std::sqrt(CV_PI) * blur_px;
    noise = noise_sigma(grey(pair.left)) * std::sqrt(pair.left.channels()) / averaged;
    pair.left.convertTo(left, CV_32F);
    pair.right.convertTo(right, CV_32F);
    cv::GaussianBlur(left, left, {0, 0}, blur_px);
    cv::GaussianBlur(right, right, {0, 0}, blur_px);
    cv::Mat du, dv;
    cv::filter2D(left, du, CV_32F, cv::Matx13f(-0.5F, 0, 0.5F), {-1, -1}, 0, cv::BORDER_REPLICATE);
    cv::filter2D(left, dv, CV_32F, cv::Matx31f(-0.5F, 0, 0.5F), {-1, -1}, 0, cv::BORDER_REPLICATE);
    const cv::Mat du_du = channel_sum(du.mul(du));
    steepness = du_du + channel_sum(dv.mul(dv));
    const cv::Size window(rows, rows);
    cv::boxFilter(du_du, across, CV_32F, window, {-1, -1}, false);
    cv::boxFilter(channel_sum(du.mul(dv)), mixed, CV_32F, window, {-1, -1}, false);
  }
  int channels() const { return left.channels(); }
};

/// An edge where it crosses a row.
struct Edge {
  int u, v;
  double shear;  // how far it moves along u from one row to the next
  double stretch() const { return std::hypot(1, shear); }  // px along the row for each px across the edge
};

/// The first edge met from where a region ends at u, going in a direction (±1); nothing if there is none
/// near, or if it runs so much along the row that a shift along the row says little.
std::optional<Edge> edge_at(const Views& views, int u, int v, int direction) {
  constexpr double farthest_px = 12, most_shear = 6;
  constexpr double least_sigmas = 4;
  const auto* steepness = views.steepness.ptr<float>(v);
  const double least = least_sigmas * least_sigmas * views.noise * views.noise / 2;
  for (int k = -1; k <= farthest_px * most_shear; ++k) {
    const int at = u + direction * k;
    if (at < 1 || at >= views.left.cols - 1) return std::nullopt;
    if (steepness[at] < least || steepness[at] < steepness[at - 1] || steepness[at] < steepness[at + 1])
      continue;
    const Edge edge{at, v, -views.mixed.at<float>(v, at) / std::max(views.across.at<float>(v, at), 1e-6F)};
    if (std::abs(edge.shear) > most_shear || k > farthest_px * edge.stretch()) return std::nullopt;
    return edge;
  }
  return std::nullopt;
}

/// What is compared: samples on the region's side of the edge, in rows that follow the edge.
struct Window {
  int first_v;
  std::array<std::array<int, width>, rows> u;
  int leftmost_u, rightmost_u;

  /// outward: the direction (±1) out of the region.
  Window(const Edge& edge, int outward) : first_v(edge.v - half_rows), u{} {
    const int first = outward > 0 ? -inside_px : -beyond_px;
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < width; ++column) {
        const double along = edge.shear * (row - half_rows) + edge.stretch() * (first + column);
        u[std::size_t(row)][std::size_t(column)] = edge.u + static_cast<int>(std::lround(along));
      }
    }
    leftmost_u = std::min(u.front().front(), u.back().front());
    rightmost_u = std::max(u.front().back(), u.back().back());
  }
};

/// The sum over channels of the variance of what a function gives for each value of the window.
template <typename Value>
double variance(const Views& views, const Window& window, const Value& value) {
  const int channels = views.channels();
  double square = 0, sums[4] = {};
  for (int row = 0; row < rows; ++row) {
    const auto* left = views.left.ptr<float>(window.first_v + row);
    const auto* right = views.right.ptr<float>(window.first_v + row);
    for (const int u : window.u[std::size_t(row)]) {
      const int at = u * channels;
      for (int c = 0; c < channels; ++c) {
        const double d = value(left + at + c, right + at + c);
        square += d * d;
        sums[c] += d;
      }
    }
  }
  for (int c = 0; c < channels; ++c) square -= sums[c] * sums[c] / window_samples;
  return square / window_samples;
}

/// The disparity of whole pixels that fits much better than any other but its neighbours.
std::optional<int> unique_disparity(const Views& views, const Window& window, int most) {
  const int channels = views.channels();
  std::vector<double> differences;
  const int last = std::min(most, window.leftmost_u - 1);
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
    if (window.leftmost_u + whole < 1 || window.rightmost_u + whole + 3 > views.left.cols)
      return std::nullopt;
    double gg = 0, gd = 0, dd = 0, weight_u = 0, weight_v = 0, g_sum[4] = {}, d_sum[4] = {};
    for (int row = 0; row < rows; ++row) {
      const int v = window.first_v + row;
      const auto* left = views.left.ptr<float>(v);
      const auto* right = views.right.ptr<float>(v) + whole * channels;
      const auto at = [&](int i) { return right[i] + part * (right[i + channels] - right[i]); };
      for (const int u : window.u[std::size_t(row)]) {
        for (int c = 0; c < channels; ++c) {
          const int i = u * channels + c;
          const double g =
              0.25 * (left[i + channels] - left[i - channels] + at(i + channels) - at(i - channels));
          const double d = left[i] - at(i);
          gg += g * g;
          gd += g * d;
          dd += d * d;
          g_sum[c] += g;
          d_sum[c] += d;
          weight_u += g * g * u;
          weight_v += g * g * v;
        }
      }
    }
    if (gg <= 0) return std::nullopt;
    match.u = weight_u / gg;
    match.v = weight_v / gg;
    for (int c = 0; c < channels; ++c) {
      gg -= g_sum[c] * g_sum[c] / window_samples;
      gd -= g_sum[c] * d_sum[c] / window_samples;
      dd -= d_sum[c] * d_sum[c] / window_samples;
    }
    if (gg < 1e-3) return std::nullopt;
    match.sigma_px = views.noise * std::sqrt(2 / gg);
    // left(u) - right(u - d) grows by the gradient times the step when d grows by the step.
    misfit = dd / window_samples;
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
      const Window window(*edge, direction);
      if (window.leftmost_u < 1 || window.rightmost_u + 1 >= region.cols) continue;
      const auto coarse = unique_disparity(views, window, most_px);
      if (!coarse) continue;
      const auto match = refined(views, window, *coarse);
      if (match && match->sigma_px < most_sigma_px) matches.push_back(*match);
    }
  }
  return matches;
}

}  // namespace graspctx::detail
