#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "graspctx/export.hpp"

namespace graspctx {

/// How one raw (unrectified, distorted) view becomes its rectified view.
struct RawView {
  enum class Distortion { plumb_bob, equidistant };             // cv::undistort / cv::fisheye models
  Eigen::Matrix3d camera_matrix = Eigen::Matrix3d::Identity();  // raw intrinsics, px
  Distortion distortion_model = Distortion::plumb_bob;
  std::vector<double> distortion;  // 0, 4, 5 or 8 (plumb_bob), 4 (equidistant)
  Eigen::Matrix3d rectified_from_raw = Eigen::Matrix3d::Identity();  // rotation
};

/// A rectified stereo pair of pinhole cameras. Left is the reference view; the camera frame is the left
/// rectified optical frame: x right, y down, z forward, metres. Pixel centres are at integers.
///
///   Z = f · B / (d + doffs),   d = u_left − u_right,   doffs = cx_right − cx_left
struct GRASPCTX_EXPORT StereoCamera {
  double focal_px = 0;                        // of both rectified views
  Eigen::Vector2d centre_px{0, 0};            // principal point of the left view (u, v)
  double baseline_m = 0;                      // > 0, the right camera is at +x
  double doffs_px = 0;                        // difference of the principal points, right minus left
  int width_px = 0, height_px = 0;            // size of the images; 0 where the calibration does not say
  std::optional<std::array<RawView, 2>> raw;  // left, right; present when images still have to be rectified

  /// Throws InvalidInput unless every number is finite and in range.
  void check() const;

  /// Depth (m) of a disparity (px). Infinity where disparity + doffs <= 0.
  double depth_m(double disparity_px) const;
  /// Disparity (px) of a depth (m).
  double disparity_px(double depth_m) const;
  /// 3D point (m) seen at (u, v) in the left view with the given disparity (px).
  Eigen::Vector3d triangulate(const Eigen::Vector2d& left_px, double disparity_px) const;
  /// Unit viewing ray through a pixel of the left view.
  Eigen::Vector3d ray(const Eigen::Vector2d& left_px) const;
  /// Pixel of the left view where a point (m, z > 0) is seen.
  Eigen::Vector2d project(const Eigen::Vector3d& point_m) const;
};

}  // namespace graspctx
