#include "graspctx/camera.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <string>

#include "graspctx/error.hpp"

namespace graspctx {

namespace {

void require(bool condition, const std::string& message) {
  if (!condition) throw InvalidInput("calibration: " + message);
}

void check_raw_view(const RawView& view, const char* side) {
  const std::string name = std::string(side) + " raw view: ";
  require(view.camera_matrix.allFinite() && view.rectified_from_raw.allFinite(),
          name + "camera and rectification matrices must be finite");
  require(view.camera_matrix(0, 0) > 0 && view.camera_matrix(1, 1) > 0,
          name + "focal lengths must be positive");
  const Eigen::Matrix3d& r = view.rectified_from_raw;
  require(
      (r * r.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3 && r.determinant() > 0,
      name + "the rectification matrix must be a rotation");
  const std::size_t n = view.distortion.size();
  const bool plumb_bob = view.distortion_model == RawView::Distortion::plumb_bob;
  require(plumb_bob ? (n == 0 || n == 4 || n == 5 || n == 8) : n == 4,
          name + "expected " + (plumb_bob ? "0, 4, 5 or 8" : "4") + " distortion coefficients, got " +
              std::to_string(n));
  for (const double value : view.distortion) {
    require(std::isfinite(value), name + "distortion coefficients must be finite");
  }
}

}  // namespace

void StereoCamera::check() const {
  require(std::isfinite(focal_px) && focal_px > 0, "the focal length must be a positive number of pixels");
  require(centre_px.allFinite(), "the principal point must be finite");
  require(std::isfinite(baseline_m) && baseline_m > 0, "the baseline must be a positive number of metres");
  require(std::isfinite(doffs_px), "doffs must be finite");
  require(width_px >= 0 && height_px >= 0, "the image size must not be negative");
  if (raw) {
    check_raw_view((*raw)[0], "left");
    check_raw_view((*raw)[1], "right");
  }
}

double StereoCamera::depth_m(double disparity_px) const {
  const double shifted_px = disparity_px + doffs_px;
  return shifted_px > 0 ? focal_px * baseline_m / shifted_px : std::numeric_limits<double>::infinity();
}

double StereoCamera::disparity_px(double depth_m) const {
  return focal_px * baseline_m / depth_m - doffs_px;
}

Eigen::Vector3d StereoCamera::triangulate(const Eigen::Vector2d& left_px, double disparity_px) const {
  const double z_m = depth_m(disparity_px);
  const Eigen::Vector2d xy_m = (left_px - centre_px) * (z_m / focal_px);
  return {xy_m.x(), xy_m.y(), z_m};
}

Eigen::Vector3d StereoCamera::ray(const Eigen::Vector2d& left_px) const {
  const Eigen::Vector2d offset_px = left_px - centre_px;
  return Eigen::Vector3d(offset_px.x(), offset_px.y(), focal_px).normalized();
}

Eigen::Vector2d StereoCamera::project(const Eigen::Vector3d& point_m) const {
  return centre_px + point_m.head<2>() * (focal_px / point_m.z());
}

}  // namespace graspctx
