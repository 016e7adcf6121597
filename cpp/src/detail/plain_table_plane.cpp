#include "detail/plain_table_plane.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>

#include "detail/plane_geometry.hpp"
#include "detail/plane_of_three.hpp"
#include "detail/quantile.hpp"

namespace graspctx::detail {

namespace {

using Coefficients = Eigen::Vector3d;  // alpha, beta, delta

constexpr double on_plane_px = 0.3, below_px = 0.6;

double residual(const Coefficients& plane, const OutlineMatch& match) {
  return match.disparity_px - (plane[0] * match.u + plane[1] * match.v + plane[2]);
}

/// What lies on the plane counts for it, what lies below it against it.
double support(const Coefficients& plane, const std::vector<OutlineMatch>& outline) {
  constexpr double against = 2;
  double sum = 0;
  for (const OutlineMatch& match : outline) {
    const double e = residual(plane, match) / on_plane_px;
    if (std::abs(e) < 1) {
      sum += 1 - e * e;
    } else if (e < -below_px / on_plane_px) {
      sum -= against;
    }
  }
  return sum;
}

/// The best of many planes through three matches. None if quite another one is nearly as good: then the
/// outlines do not tell which it is, however well they lie on either.
std::optional<Coefficients> drawn_plane(const std::vector<OutlineMatch>& outline, const StereoCamera& camera,
                                        const std::function<bool(const TablePlane&)>& is_support) {
  constexpr int draws = 1500;
  std::mt19937 random(20090512);  // fixed: the same scene always gives the same plane
  struct Drawn {
    Coefficients plane;
    Eigen::Vector3d normal;
    double support;
  };
  std::vector<Drawn> drawn;
  for (int draw = 0; draw < draws; ++draw) {
    const auto drawn_through = plane_of_three(outline, random);
    if (!drawn_through) continue;
    const Eigen::Vector3d& plane = *drawn_through;
    const TablePlane table = plane_from_disparity(plane, camera);
    if (is_support(table)) drawn.push_back({plane, table.normal, support(plane, outline)});
  }
  const auto best = std::max_element(drawn.begin(), drawn.end(),
                                     [](const Drawn& a, const Drawn& b) { return a.support < b.support; });
  if (best == drawn.end() || best->support <= 0) return std::nullopt;
  const double alike = std::cos(5.0 * CV_PI / 180);
  constexpr double nearly = 0.5;
  for (const Drawn& rival : drawn) {
    if (rival.normal.dot(best->normal) < alike && rival.support > nearly * best->support) return std::nullopt;
  }
  return best->plane;
}

/// The spread of the matches around the plane, from those below it: above there are objects as well.
double spread_below_px(const Coefficients& plane, const std::vector<OutlineMatch>& outline) {
  constexpr double least_px = 0.06;
  std::vector<double> errors;
  for (const OutlineMatch& match : outline) {
    const double e = -residual(plane, match);
    if (e >= 0 && e < below_px) errors.push_back(e);
  }
  return errors.empty() ? least_px : std::max(least_px, 1.4826 * median(std::move(errors)));
}

struct Fit {
  Coefficients plane{0, 0, 0};
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double sigma_px = 0;
  int on_plane = 0;
};

/// Tukey's M-estimator by re-weighted least squares, and how well it knows the plane.
Fit refined(const Coefficients& start, const std::vector<OutlineMatch>& outline) {
  // Windows of neighbouring rows share most of their pixels: that many matches say as much as one.
  constexpr double alike = 7;
  Fit fit;
  fit.plane = start;
  for (int iteration = 0; iteration < 10; ++iteration) {
    fit.sigma_px = spread_below_px(fit.plane, outline);
    const double cut_off = 3.5 * fit.sigma_px;
    Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
    fit.on_plane = 0;
    for (const OutlineMatch& match : outline) {
      const double e = residual(fit.plane, match) / cut_off;
      if (std::abs(e) >= 1) continue;
      const double weight = (1 - e * e) * (1 - e * e);
      const Eigen::Vector3d row(match.u, match.v, 1);
      normal_matrix += weight * row * row.transpose();
      right_side += weight * match.disparity_px * row;
      ++fit.on_plane;
    }
    const Eigen::FullPivLU<Eigen::Matrix3d> solver(normal_matrix);
    if (fit.on_plane < 3 || !solver.isInvertible()) {
      fit.on_plane = 0;
      return fit;
    }
    fit.plane = solver.solve(right_side);
    fit.covariance = alike * fit.sigma_px * fit.sigma_px * solver.inverse();
  }
  return fit;
}

}  // namespace

std::optional<TablePlane> plane_under_outline(const std::vector<OutlineMatch>& outline,
                                              const StereoCamera& camera, const Eigen::Vector2d& centre_px,
                                              const std::function<bool(const TablePlane&)>& is_support) {
  constexpr int least_matches = 20;
  if (outline.size() < least_matches) return std::nullopt;
  const auto drawn = drawn_plane(outline, camera, is_support);
  if (!drawn) return std::nullopt;
  const Fit fit = refined(*drawn, outline);
  if (fit.on_plane < least_matches || fit.sigma_px > on_plane_px) return std::nullopt;
  TablePlane plane = plane_from_disparity(fit.plane, camera);
  plane.sigma_px = fit.sigma_px;
  if (!is_support(plane)) return std::nullopt;

  // One standard deviation along each axis of the uncertainty: how far do the normal and the height move?
  constexpr double most_rad = 0.025, most_m = 0.004;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(fit.covariance);
  const double centre_disparity = plane_disparity(plane, centre_px.x(), centre_px.y());
  double turned_square = 0, raised_square = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step =
        std::sqrt(std::max(0.0, axes.eigenvalues()[axis])) * axes.eigenvectors().col(axis);
    const TablePlane moved = plane_from_disparity(fit.plane + step, camera);
    turned_square += (moved.normal - plane.normal).squaredNorm();
    const double raised_m = height_m(plane, camera, centre_px.x(), centre_px.y(),
                                     plane_disparity(moved, centre_px.x(), centre_px.y()));
    raised_square += raised_m * raised_m;
  }
  if (centre_disparity + camera.doffs_px <= 0) return std::nullopt;
  if (std::sqrt(turned_square) > most_rad || std::sqrt(raised_square) > most_m) return std::nullopt;
  return plane;
}

std::optional<TablePlane> level_plane_under_outline(const std::vector<OutlineMatch>& outline,
                                                    const StereoCamera& camera,
                                                    const Eigen::Vector3d& normal) {
  constexpr int least_matches = 15;
  constexpr double least_share =
      0.25;  // some height is that of a few matches wherever an object's outline is
  // d + doffs of a plane with this normal is proportional to that of the plane at 1 m.
  const TablePlane unit = plane_in_view(normal, 1, camera);
  const auto through = [&](const OutlineMatch& match) {
    return (plane_disparity(unit, match.u, match.v) + camera.doffs_px) /
           (match.disparity_px + camera.doffs_px);
  };
  const auto coefficients = [&](double offset_m) {
    const TablePlane plane = plane_in_view(normal, offset_m, camera);
    return Coefficients(plane.alpha, plane.beta, plane.delta_px);
  };
  double best_offset_m = 0, best_support = 0;
  for (const OutlineMatch& match : outline) {
    const double offset_m = through(match);
    if (!(offset_m > 0) || !std::isfinite(offset_m)) continue;
    const double s = support(coefficients(offset_m), outline);
    if (s > best_support) {
      best_support = s;
      best_offset_m = offset_m;
    }
  }
  if (best_support <= 0) return std::nullopt;
  std::vector<double> offsets_m;
  for (const OutlineMatch& match : outline) {
    if (std::abs(residual(coefficients(best_offset_m), match)) < on_plane_px)
      offsets_m.push_back(through(match));
  }
  if (offsets_m.size() < least_matches || double(offsets_m.size()) < least_share * double(outline.size()))
    return std::nullopt;
  const double offset_m = median(std::move(offsets_m));
  TablePlane plane = plane_in_view(normal, offset_m, camera);
  plane.sigma_px = spread_below_px(coefficients(offset_m), outline);
  return plane;
}

}  // namespace graspctx::detail
