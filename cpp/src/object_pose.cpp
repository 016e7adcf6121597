#include "graspctx/object_pose.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "detail/check.hpp"
#include "detail/quantile.hpp"
#include "detail/segment_disparity.hpp"

namespace graspctx {

namespace {

constexpr double pulled_in =
    0.85;  // of the way to the boundary: a point on the silhouette matches background
constexpr double flat_height_m = 0.04;  // lower objects are taken to lie flat on the table

/// The segment's ellipse of equal second moments: III-D.
struct Ellipse {
  Eigen::Vector2d centre_px, major_direction, minor_direction;  // unit directions
};

Ellipse fit_ellipse(const cv::Mat& mask) {
  const cv::Moments m = cv::moments(mask, /*binaryImage=*/true);
  const double angle = 0.5 * std::atan2(2 * m.mu11, m.mu20 - m.mu02);
  const Eigen::Vector2d major(std::cos(angle), std::sin(angle));
  return {{m.m10 / m.m00, m.m01 / m.m00}, major, {-major.y(), major.x()}};
}

bool on_mask(const cv::Mat& mask, const Eigen::Vector2d& point_px) {
  const cv::Point p(static_cast<int>(std::lround(point_px.x())), static_cast<int>(std::lround(point_px.y())));
  return cv::Rect({0, 0}, mask.size()).contains(p) && mask.at<uchar>(p) > 0;
}

/// Distance from a point to the last pixel of the segment in a direction.
double reach_px(const cv::Mat& mask, const Eigen::Vector2d& from_px, const Eigen::Vector2d& direction) {
  double reach = 0;
  for (double t = 0.5; t < mask.cols + mask.rows; t += 0.5) {
    if (on_mask(mask, from_px + t * direction)) reach = t;
  }
  return reach;
}

/// Median disparity of the segment around a pixel, in a window growing until it holds some; NaN if it has
/// none.
double segment_disparity(const cv::Mat& mask, const cv::Mat& disparity, const Eigen::Vector2d& at_px) {
  for (int half_px = 2; half_px < 2 * std::max(mask.cols, mask.rows); half_px *= 2) {
    const double median_px = detail::median_disparity(mask, disparity, at_px, half_px);
    if (std::isfinite(median_px)) return median_px;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// 95th percentile of the segment's height above the table.
double object_height_m(const cv::Mat& mask, const cv::Mat& disparity, const StereoCamera& camera,
                       const TablePlane& table) {
  std::vector<double> heights;
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      if (!mask.at<uchar>(v, u) || !std::isfinite(disparity.at<float>(v, u))) continue;
      const double height = table.height_m(camera.triangulate({u, v}, disparity.at<float>(v, u)));
      if (std::isfinite(height)) heights.push_back(height);
    }
  }
  return heights.empty() ? 0 : detail::quantile(std::move(heights), 0.95);
}

Eigen::Vector3d without_component(const Eigen::Vector3d& vector, const Eigen::Vector3d& unit) {
  return vector - vector.dot(unit) * unit;
}

/// The same length, turned into a new direction's own sense or its opposite, whichever is nearer.
Eigen::Vector3d turned(const Eigen::Vector3d& vector, const Eigen::Vector3d& direction) {
  const double sign = vector.dot(direction) < 0 ? -1 : 1;
  return sign * vector.norm() * direction.normalized();
}

/// An object on a table lies flat or stands upright: three noisy points need not say how exactly.
void align_with_table(ObjectPose& pose, const Eigen::Vector3d& up, double height_m) {
  constexpr double degenerate = 1e-6;
  if (height_m < flat_height_m) {
    const Eigen::Vector3d major = without_component(pose.major_axis_m, up);
    if (major.norm() < degenerate) return;
    pose.major_axis_m = turned(pose.major_axis_m, major);
    pose.minor_axis_m = turned(pose.minor_axis_m, up.cross(major));
    pose.normal = up;
    return;
  }
  const Eigen::Vector3d horizontal_normal = without_component(pose.normal, up);
  const Eigen::Vector3d towards_camera = without_component(-pose.centroid_m, up);
  const Eigen::Vector3d normal =
      (horizontal_normal.norm() > 0.2 ? horizontal_normal : towards_camera).normalized();
  if (!normal.allFinite()) return;
  const bool major_stands =
      std::abs(pose.major_axis_m.normalized().dot(up)) >= std::abs(pose.minor_axis_m.normalized().dot(up));
  Eigen::Vector3d& standing = major_stands ? pose.major_axis_m : pose.minor_axis_m;
  Eigen::Vector3d& lying = major_stands ? pose.minor_axis_m : pose.major_axis_m;
  standing = turned(standing, up);
  lying = turned(lying, up.cross(normal));
  pose.normal = normal;
}

}  // namespace

std::optional<ObjectPose> estimate_object_pose(const FovealPair& pair, const cv::Mat& mask,
                                               const cv::Mat& disparity, const StereoCamera& camera,
                                               const std::optional<TablePlane>& table) {
  detail::require_mask(mask, disparity.size(), "object mask");
  if (cv::countNonZero(mask) == 0) return std::nullopt;

  // III-D: the centroid, and a point of the boundary on each axis; from both ends of each axis, since one bad
  // point tilts the plane.
  const Ellipse ellipse = fit_ellipse(mask);
  const std::array<Eigen::Vector2d, 4> directions{ellipse.major_direction, -ellipse.major_direction,
                                                  ellipse.minor_direction, -ellipse.minor_direction};
  ObjectPose pose;
  const auto locate = [&](const Eigen::Vector2d& point_px) -> std::optional<Eigen::Vector3d> {
    const double segment_px = segment_disparity(mask, disparity, point_px);
    if (!std::isfinite(segment_px)) return std::nullopt;
    double matched_px = segment_px;
    const auto match = match_patch(pair, pair.left.view_from_image(point_px), segment_px);
    // A match that leaves the segment's depth has found something else: a hole, an occlusion, the background.
    constexpr double agreeing_px = 2;
    if (match && on_mask(mask, point_px) && std::abs(match->disparity_px - segment_px) <= agreeing_px) {
      matched_px = match->disparity_px;
    } else {
      pose.source = ObjectPose::Source::segment_depth;
    }
    const Eigen::Vector3d point_m = camera.triangulate(point_px, matched_px);
    return point_m.allFinite() ? std::optional(point_m) : std::nullopt;
  };

  const auto centroid_m = locate(ellipse.centre_px);
  if (!centroid_m) return std::nullopt;
  std::array<Eigen::Vector3d, 4> ends_m;
  std::array<Eigen::Vector2d, 4> boundary_px;
  for (std::size_t i = 0; i < 4; ++i) {
    const double reach = reach_px(mask, ellipse.centre_px, directions[i]);
    boundary_px[i] = ellipse.centre_px + reach * directions[i];
    const auto end_m = locate(ellipse.centre_px + pulled_in * reach * directions[i]);
    if (!end_m) return std::nullopt;
    ends_m[i] = *end_m;
  }
  pose.centroid_m = *centroid_m;
  pose.centroid_px = ellipse.centre_px;
  pose.major_px = boundary_px[0];
  pose.minor_px = boundary_px[2];
  pose.major_axis_m = (ends_m[0] - ends_m[1]) / (2 * pulled_in);
  pose.minor_axis_m = (ends_m[2] - ends_m[3]) / (2 * pulled_in);
  pose.normal = pose.major_axis_m.cross(pose.minor_axis_m);
  constexpr double degenerate_m2 = 1e-10;
  if (!(pose.normal.norm() > degenerate_m2)) return std::nullopt;
  pose.normal.normalize();
  if (pose.normal.dot(pose.centroid_m) > 0) pose.normal = -pose.normal;

  if (table) align_with_table(pose, table->normal, object_height_m(mask, disparity, camera, *table));
  return pose;
}

}  // namespace graspctx
