#pragma once
#include <Eigen/Core>

#include "graspctx/camera.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

inline double plane_disparity(const TablePlane& plane, double u, double v) {
  return plane.alpha * u + plane.beta * v + plane.delta_px;
}

/// The table through d = alpha·u + beta·v + delta: with d + doffs = f·B / Z and u = f·X/Z + cx it holds
/// m·P = f·B, m = (alpha·f, beta·f, alpha·cx + beta·cy + delta + doffs).
inline TablePlane plane_from_disparity(const Eigen::Vector3d& coefficients, const StereoCamera& camera) {
  TablePlane plane;
  plane.alpha = coefficients[0];
  plane.beta = coefficients[1];
  plane.delta_px = coefficients[2];
  const Eigen::Vector3d m(
      plane.alpha * camera.focal_px, plane.beta * camera.focal_px,
      plane_disparity(plane, camera.centre_px.x(), camera.centre_px.y()) + camera.doffs_px);
  plane.normal = -m / m.norm();
  plane.offset_m = camera.focal_px * camera.baseline_m / m.norm();
  return plane;
}

/// Height (m) above the table of what is seen at (u, v) with the given disparity.
inline double height_m(const TablePlane& plane, const StereoCamera& camera, double u, double v,
                       double disparity_px) {
  return plane.offset_m * (disparity_px - plane_disparity(plane, u, v)) / (disparity_px + camera.doffs_px);
}

}  // namespace graspctx::detail
