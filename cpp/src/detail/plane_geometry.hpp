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

/// The same table from its unit normal and offset_m, the other way round. offset_m must not be 0.
inline TablePlane plane_in_view(const Eigen::Vector3d& normal, double offset_m, const StereoCamera& camera) {
  const Eigen::Vector3d m = -camera.focal_px * camera.baseline_m / offset_m * normal;
  TablePlane plane;
  plane.alpha = m.x() / camera.focal_px;
  plane.beta = m.y() / camera.focal_px;
  plane.delta_px =
      m.z() - camera.doffs_px - plane.alpha * camera.centre_px.x() - plane.beta * camera.centre_px.y();
  plane.normal = normal;
  plane.offset_m = offset_m;
  return plane;
}

/// Height (m) above the table of what is seen at (u, v) with the given disparity.
inline double height_m(const TablePlane& plane, const StereoCamera& camera, double u, double v,
                       double disparity_px) {
  return plane.offset_m * (disparity_px - plane_disparity(plane, u, v)) / (disparity_px + camera.doffs_px);
}

}  // namespace graspctx::detail
