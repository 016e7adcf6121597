#include "detail/vertical_offset.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "detail/quantile.hpp"
#include "detail/texture.hpp"

namespace graspctx::detail {

namespace {

constexpr int half_window_px = 7;
constexpr int reach_px = 3;     // of the search along the row: how wrong a disparity may be
constexpr int vertical_px = 7;  // of the search across the rows
constexpr double least_correlation = 0.85;
constexpr int apart_px = 2;  // the best place and others
constexpr double most_elsewhere = 0.9;

struct Shift {
  double u;          // of a corner from the middle of the image
  double offset_px;  // v in the right view less v in the left one
};

double peak_between(double before, double at, double after) {
  const double curvature = before - 2 * at + after;
  return curvature < 0 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0;
}

/// Where a window of the left view is found in the right one, vertically; nothing if it is not, or not
/// inside the area that is searched.
std::optional<double> find_vertically(const cv::Mat& left, const cv::Mat& right, const cv::Point& corner,
                                      float disparity_px) {
  const int side = 2 * half_window_px + 1;
  const cv::Rect window(corner.x - half_window_px, corner.y - half_window_px, side, side);
  const cv::Rect searched(window.x - static_cast<int>(std::lround(disparity_px)) - reach_px,
                          window.y - vertical_px, side + 2 * reach_px, side + 2 * vertical_px);
  const cv::Rect image({0, 0}, left.size());
  if ((window & image) != window || (searched & image) != searched) return std::nullopt;
  cv::Mat correlation;
  cv::matchTemplate(right(searched), left(window), correlation, cv::TM_CCOEFF_NORMED);
  double best;
  cv::Point at;
  cv::minMaxLoc(correlation, nullptr, &best, nullptr, &at);
  const bool inside = at.x > 0 && at.y > 0 && at.x < correlation.cols - 1 && at.y < correlation.rows - 1;
  if (!(best >= least_correlation) || !inside) return std::nullopt;
  // What fits farther off about as well is an edge or a pattern.
  double elsewhere;
  cv::Mat others = correlation.clone();
  others(cv::Rect(at.x - apart_px, at.y - apart_px, 2 * apart_px + 1, 2 * apart_px + 1) &
         cv::Rect({0, 0}, others.size()))
      .setTo(-1);
  cv::minMaxLoc(others, nullptr, &elsewhere);
  if (elsewhere > most_elsewhere * best) return std::nullopt;
  return at.y - vertical_px +
         peak_between(correlation.at<float>(at.y - 1, at.x), best, correlation.at<float>(at.y + 1, at.x));
}

/// offset + u · slope through the shifts, robustly: the median, then Tukey's weights.
Eigen::Vector2d fit_line(const std::vector<Shift>& shifts) {
  std::vector<double> offsets;
  for (const Shift& shift : shifts) offsets.push_back(shift.offset_px);
  Eigen::Vector2d line(median(offsets), 0);
  double scale_px = 1.5;
  for (int iteration = 0; iteration < 8; ++iteration) {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right_side = Eigen::Vector2d::Zero();
    std::vector<double> residuals;
    for (const Shift& shift : shifts) {
      const double residual = shift.offset_px - line[0] - line[1] * shift.u;
      residuals.push_back(std::abs(residual));
      const double share = residual / scale_px;
      if (std::abs(share) >= 1) continue;
      const double weight = (1 - share * share) * (1 - share * share);
      const Eigen::Vector2d terms(1, shift.u);
      normal += weight * terms * terms.transpose();
      right_side += weight * shift.offset_px * terms;
    }
    if (normal.determinant() < 1e-6) break;
    line = normal.ldlt().solve(right_side);
    scale_px = std::clamp(4.7 * 1.48 * median(std::move(residuals)), 0.3, 1.5);
  }
  return line;
}

}  // namespace

std::optional<VerticalOffset> measure_vertical_offset(const RectifiedPair& pair, const Disparity& disparity) {
  constexpr int most_corners = 200, least_corners = 12;
  const cv::Mat left = grey(pair.left), right = grey(pair.right);
  std::vector<cv::Point2f> corners;
  // Harris' measure is negative along edges. On a slanted edge a shift along the row looks like one across
  // it.
  constexpr double quality = 0.0005, edge_penalty = 0.15, spacing_px = 10;
  constexpr int block_px = 5;
  cv::goodFeaturesToTrack(left, corners, most_corners, quality, spacing_px,
                          disparity.reliable == disparity.reliable, block_px, true, edge_penalty);
  std::vector<Shift> shifts;
  for (const cv::Point2f& found : corners) {
    const cv::Point corner(found);
    const auto offset_px = find_vertically(left, right, corner, disparity.reliable.at<float>(corner));
    if (offset_px) {
      shifts.push_back({corner.x - 0.5 * (left.cols - 1), *offset_px});
    }
  }
  if (static_cast<int>(shifts.size()) < least_corners) return std::nullopt;
  const Eigen::Vector2d line = fit_line(shifts);
  // Windows that show different things are found anywhere.
  constexpr double alike_px = 1;
  const auto alike = std::count_if(shifts.begin(), shifts.end(), [&](const Shift& shift) {
    return std::abs(shift.offset_px - line[0] - line[1] * shift.u) < alike_px;
  });
  if (alike < least_corners || 2 * alike < static_cast<std::ptrdiff_t>(shifts.size())) return std::nullopt;
  return VerticalOffset{line[0], std::atan(line[1]), static_cast<int>(shifts.size())};
}

}  // namespace graspctx::detail
