#include "graspctx/grasp.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "detail/check.hpp"

namespace graspctx {

namespace {

constexpr double pi = 3.14159265358979323846;

/// The narrowest chord of the segment through a point, px.
double part_width_px(const cv::Mat& mask, const Eigen::Vector2d& at_px) {
  const cv::Rect image({0, 0}, mask.size());
  const auto reach_px = [&](const Eigen::Vector2d& direction) {
    double t = 0;
    while (true) {
      const Eigen::Vector2d p = at_px + (t + 0.5) * direction;
      const cv::Point pixel(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
      if (!image.contains(pixel) || !mask.at<uchar>(pixel)) return t;
      t += 0.5;
    }
  };
  constexpr int directions = 18;
  double narrowest_px = std::numeric_limits<double>::infinity();
  for (int i = 0; i < directions; ++i) {
    const Eigen::Vector2d direction(std::cos(i * pi / directions), std::sin(i * pi / directions));
    narrowest_px = std::min(narrowest_px, reach_px(direction) + reach_px(-direction));
  }
  return narrowest_px;
}

Eigen::Matrix4d hand_frame(const ApproachAndWrist& hand, const Eigen::Vector3d& position_m) {
  Eigen::Matrix4d cam_from_hand = Eigen::Matrix4d::Identity();
  cam_from_hand.block<3, 1>(0, 0) = hand.closing;
  cam_from_hand.block<3, 1>(0, 1) = hand.approach.cross(hand.closing);
  cam_from_hand.block<3, 1>(0, 2) = hand.approach;
  cam_from_hand.block<3, 1>(0, 3) = position_m;
  return cam_from_hand;
}

}  // namespace

void HandOptions::check() const {
  for (const double length_m :
       {max_opening_m, finger_length_m, finger_width_m, finger_thickness_m, finger_spread_m, palm_radius_m}) {
    detail::require_option(std::isfinite(length_m) && length_m > 0,
                           "hand dimensions must be positive metres");
  }
  for (const double length_m : {opening_margin_m, tip_beyond_m, table_clearance_m, retreat_m}) {
    detail::require_option(std::isfinite(length_m) && length_m >= 0, "hand distances must not be negative");
  }
}

const char* name_of(ApproachRule rule) {
  switch (rule) {
    case ApproachRule::plane_normal:
      return "plane_normal";
    case ApproachRule::major_axis:
      return "major_axis";
    case ApproachRule::minor_axis:
      return "minor_axis";
  }
  throw InvalidInput("approach rule: expected plane_normal, major_axis or minor_axis");
}

ApproachAndWrist approach_by_rule(ApproachRule rule, const Eigen::Vector2d& grasp_px,
                                  const ObjectPose& pose) {
  const Eigen::Vector2d x_b = grasp_px - pose.centroid_px;
  const Eigen::Vector2d x_ma = pose.major_px - pose.centroid_px, x_mi = pose.minor_px - pose.centroid_px;
  // The hand comes from outside: from the side of the axis that the point lies on, and from the camera's
  // side.
  const auto inwards = [&](const Eigen::Vector3d& axis, const Eigen::Vector2d& axis_px) -> Eigen::Vector3d {
    return (axis_px.dot(x_b) < 0 ? 1.0 : -1.0) * axis.normalized();
  };

  // III-D, Eq. 3
  ApproachAndWrist result;
  result.rule = rule;
  switch (rule) {
    case ApproachRule::plane_normal:
      result.approach = -pose.normal;
      result.closing = pose.minor_axis_m;
      break;
    case ApproachRule::major_axis:
      result.approach = inwards(pose.major_axis_m, x_ma);
      result.closing = pose.normal;
      break;
    case ApproachRule::minor_axis:
      result.approach = inwards(pose.minor_axis_m, x_mi);
      result.closing = pose.normal;
      break;
  }
  result.approach.normalize();
  result.closing -= result.closing.dot(result.approach) * result.approach;
  result.closing.normalize();
  return result;
}

ApproachAndWrist approach_and_wrist(const Eigen::Vector2d& grasp_px, const ObjectPose& pose,
                                    double threshold) {
  const Eigen::Vector2d x_b = grasp_px - pose.centroid_px;
  const Eigen::Vector2d x_ma = pose.major_px - pose.centroid_px, x_mi = pose.minor_px - pose.centroid_px;
  const auto along = [&](const Eigen::Vector2d& axis_px) {
    return axis_px.norm() > 0 ? std::abs(axis_px.dot(x_b)) / axis_px.norm() : 0.0;
  };
  // III-D, Eq. 3: in the middle along the normal, otherwise along the axis that the point is farther out on.
  if (x_b.norm() < threshold * x_mi.norm())
    return approach_by_rule(ApproachRule::plane_normal, grasp_px, pose);
  if (along(x_ma) > along(x_mi)) return approach_by_rule(ApproachRule::major_axis, grasp_px, pose);
  return approach_by_rule(ApproachRule::minor_axis, grasp_px, pose);
}

std::optional<std::string> table_conflict(const Eigen::Matrix4d& cam_from_hand, double opening_m,
                                          const TablePlane& table, const HandOptions& hand) {
  const auto height_m = [&](const Eigen::Vector3d& hand_point_m) {
    return table.height_m(cam_from_hand.block<3, 3>(0, 0) * hand_point_m + cam_from_hand.block<3, 1>(0, 3));
  };
  const Eigen::Vector3d approach = cam_from_hand.block<3, 1>(0, 2);
  if (height_m(Eigen::Vector3d::Zero()) < hand.table_clearance_m) return "the grasp point lies in the table";

  // Fingertips reach a little past the grasp point, less where the table is nearer than that.
  const double descent = std::max(0.0, -approach.dot(table.normal));
  const double room_m = height_m(Eigen::Vector3d::Zero()) - hand.table_clearance_m;
  const double tip_m = descent > 0.7 ? std::min(hand.tip_beyond_m, room_m / descent) : hand.tip_beyond_m;

  // Corners of the open fingers and the palm's rim. Thumb at −x, the two fingers at +x.
  std::vector<Eigen::Vector3d> corners_m;
  const double outer_m = opening_m / 2 + hand.finger_thickness_m;
  for (const double y_m : {-hand.finger_width_m / 2, hand.finger_width_m / 2}) {
    corners_m.emplace_back(-outer_m, y_m, tip_m);
    for (const double finger : {-0.5, 0.5}) {
      corners_m.emplace_back(outer_m, finger * hand.finger_spread_m + y_m, tip_m);
    }
  }
  const double palm_z_m = tip_m - hand.finger_length_m;
  for (int i = 0; i < 16; ++i) {
    const double angle = i * 2 * pi / 16;
    corners_m.emplace_back(hand.palm_radius_m * std::cos(angle), hand.palm_radius_m * std::sin(angle),
                           palm_z_m);
  }

  for (const double back_m : {0.0, hand.retreat_m}) {
    double lowest_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& corner_m : corners_m) {
      lowest_m = std::min(lowest_m, height_m(corner_m - Eigen::Vector3d(0, 0, back_m)));
    }
    constexpr double rounding_m = 1e-9;
    if (lowest_m < hand.table_clearance_m - rounding_m) {
      return back_m > 0 ? "the hand would come through the table" : "the hand would touch the table";
    }
  }
  return std::nullopt;
}

GraspConfiguration configure_grasp(const Eigen::Vector2d& left_px, const StereoMatch& match,
                                   const cv::Mat& mask, const StereoCamera& camera, const ObjectPose& pose,
                                   const std::optional<TablePlane>& table, const HandOptions& hand,
                                   double threshold) {
  GraspConfiguration grasp;
  grasp.left_px = left_px;
  grasp.right_px = left_px - Eigen::Vector2d(match.disparity_px, 0);

  // What is seen is the near side of the part; the fingers close around its middle.
  const Eigen::Vector3d surface_m = camera.triangulate(left_px, match.disparity_px);
  const double metres_per_px = surface_m.z() / camera.focal_px;
  const double width_m = part_width_px(mask, left_px) * metres_per_px;
  constexpr double deepest_m = 0.02;
  grasp.position_m = surface_m + std::min(width_m / 2, deepest_m) * camera.ray(left_px);
  grasp.opening_m = width_m + 2 * hand.opening_margin_m;
  if (table) {
    // No part reaches below the table: its middle lies at least half its width above. Depth alone is not
    // known well enough for a pencil.
    const double least_m = std::min(width_m / 2, deepest_m), height_m = table->height_m(grasp.position_m);
    const double sinks = -table->normal.dot(camera.ray(left_px));
    constexpr double grazing = 0.1;
    if (height_m < least_m && sinks > grazing)
      grasp.position_m -= (least_m - height_m) / sinks * camera.ray(left_px);
  }

  // dZ = Z² / (f·B) · dd; across the ray a point is known to a pixel.
  const double depth_stddev_m = surface_m.z() * metres_per_px / camera.baseline_m * match.disparity_stddev_px;
  grasp.position_stddev_m = {metres_per_px, metres_per_px, depth_stddev_m};

  // Eq. 3 first; where that would take the hand through the table, the other cases of the rule.
  const ApproachRule chosen = approach_and_wrist(left_px, pose, threshold).rule;
  std::vector<ApproachRule> rules{chosen};
  for (const ApproachRule rule :
       {ApproachRule::minor_axis, ApproachRule::plane_normal, ApproachRule::major_axis}) {
    if (rule != chosen) rules.push_back(rule);
  }
  for (const ApproachRule rule : rules) {
    const ApproachAndWrist wrist = approach_by_rule(rule, left_px, pose);
    const Eigen::Matrix4d cam_from_hand = hand_frame(wrist, grasp.position_m);
    std::optional<std::string> conflict;
    if (grasp.opening_m > hand.max_opening_m) {
      conflict = "the part is wider than the hand opens";
    } else if (table) {
      conflict = table_conflict(cam_from_hand, grasp.opening_m, *table, hand);
    }
    if (rule == chosen || !conflict) {
      grasp.rule = rule;
      grasp.approach = wrist.approach;
      grasp.closing = wrist.closing;
      grasp.cam_from_hand = cam_from_hand;
      grasp.feasible = !conflict;
      grasp.infeasible_because = conflict;
    }
    if (!conflict) break;
  }
  return grasp;
}

}  // namespace graspctx
