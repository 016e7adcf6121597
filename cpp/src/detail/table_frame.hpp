#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "detail/relief.hpp"
#include "graspctx/camera.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// Bird's-eye view of the table: its own two axes, and how far it is seen to reach.
struct TableFrame {
  Eigen::Vector3d right, nearer;  // unit vectors along the table, in the camera frame
  std::vector<cv::Point2f> hull;  // m, convex, of what lies on the plane; empty if hardly anything does

  /// Where a point of the camera frame (m) is on the table, seen from right above (m).
  cv::Point2f of(const Eigen::Vector3d& point_m) const {
    return {static_cast<float>(right.dot(point_m)), static_cast<float>(nearer.dot(point_m))};
  }
};

TableFrame table_frame(const Relief& relief, const TablePlane& plane, const StereoCamera& camera);

}  // namespace graspctx::detail
