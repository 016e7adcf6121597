#include "graspctx/shape_context.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "detail/check.hpp"
#include "detail/log_polar.hpp"

namespace graspctx {

namespace {

constexpr double two_pi = 6.283185307179586476925286766559;

double mean_pairwise_distance(const std::vector<cv::Point2f>& points) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      sum += std::hypot(static_cast<double>(points[j].x) - points[i].x,
                        static_cast<double>(points[j].y) - points[i].y);
    }
  }
  const double pairs = 0.5 * static_cast<double>(points.size()) * static_cast<double>(points.size() - 1);
  return sum / pairs;
}

/// Outer radius of each ring, log-spaced from inner_radius to outer_radius (Belongie et al. 2002).
std::vector<double> ring_radii(const ShapeContextOptions& options) {
  std::vector<double> radii(static_cast<std::size_t>(options.radial_bins));
  const double last = std::max(1, options.radial_bins - 1);
  for (int k = 0; k < options.radial_bins; ++k) {
    radii[static_cast<std::size_t>(k)] =
        options.inner_radius * std::pow(options.outer_radius / options.inner_radius, k / last);
  }
  radii.back() = options.outer_radius;
  return radii;
}

}  // namespace

namespace detail {

LogPolarBins::LogPolarBins(const std::vector<cv::Point2f>& points, const ShapeContextOptions& options,
                           const std::vector<float>& gradients_rad, const std::vector<float>& border_px)
    : points_(points), options_(options), gradients_rad_(gradients_rad), border_px_(border_px) {
  const double mean_distance = points.size() < 2 ? 0 : mean_pairwise_distance(points);
  unit_px_ = mean_distance > 0 ? mean_distance : 1;
  radii_ = ring_radii(options);
}

std::vector<double> LogPolarBins::ring_radii_px() const {
  std::vector<double> radii_px = radii_;
  for (double& radius : radii_px) radius *= unit_px_;
  return radii_px;
}

int LogPolarBins::bin(std::size_t from, std::size_t to) const {
  if (from == to) return -1;
  const double du = static_cast<double>(points_[to].x) - points_[from].x;
  const double dv = static_cast<double>(points_[to].y) - points_[from].y;
  const double radius = std::hypot(du, dv) / unit_px_;
  int ring = 0;
  while (ring < options_.radial_bins && radius >= radii_[static_cast<std::size_t>(ring)]) ++ring;
  if (ring == options_.radial_bins) return -1;  // beyond the outer radius

  const double turn = options_.relative_to_gradient ? gradients_rad_[from] : 0.0;
  double turns = (std::atan2(dv, du) - turn) / two_pi;
  turns -= std::floor(turns);
  const int sector = std::min(static_cast<int>(turns * options_.angular_bins), options_.angular_bins - 1);
  return sector * options_.radial_bins + ring;
}

}  // namespace detail

void ShapeContextOptions::check() const {
  detail::require_option(angular_bins >= 1 && angular_bins <= 360, "angular_bins must be 1 to 360");
  detail::require_option(radial_bins >= 1 && radial_bins <= 100, "radial_bins must be 1 to 100");
  detail::require_option(outline_px >= 0 && outline_px <= 1000, "outline_px must be 0 to 1000");
  detail::require_option(std::isfinite(inner_radius) && std::isfinite(outer_radius) && inner_radius > 0 &&
                             outer_radius > inner_radius,
                         "radii must be finite with 0 < inner_radius < outer_radius");
}

FeatureMatrix shape_contexts(const std::vector<cv::Point2f>& points, const ShapeContextOptions& options,
                             const std::vector<float>& gradients_rad, const std::vector<float>& border_px) {
  options.check();
  if (options.relative_to_gradient && gradients_rad.size() != points.size()) {
    throw InvalidInput("gradients: expected one for each of the " + std::to_string(points.size()) +
                       " points, got " + std::to_string(gradients_rad.size()));
  }
  if (options.outline_px > 0 && border_px.size() != points.size()) {
    throw InvalidInput("distances to the border: expected one for each of the " +
                       std::to_string(points.size()) + " points, got " + std::to_string(border_px.size()));
  }
  for (const cv::Point2f& p : points) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y))
      throw InvalidInput("points: all coordinates must be finite");
  }
  for (const float gradient : gradients_rad) {
    if (!std::isfinite(gradient)) throw InvalidInput("gradients: all must be finite");
  }
  for (const float distance : border_px) {
    if (!std::isfinite(distance)) throw InvalidInput("distances to the border: all must be finite");
  }

  const auto n = static_cast<Eigen::Index>(points.size());
  FeatureMatrix counts = FeatureMatrix::Zero(n, options.bins());
  if (n < 2) return counts;
  const detail::LogPolarBins bins(points, options, gradients_rad, border_px);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      bins.visit(static_cast<std::size_t>(i), static_cast<std::size_t>(j),
                 [&](int bin) { counts(i, bin) += 1; });
    }
  }
  return counts;
}

}  // namespace graspctx
