#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "graspctx/camera.hpp"
#include "graspctx/export.hpp"
#include "graspctx/object_pose.hpp"
#include "graspctx/segmentation.hpp"
#include "graspctx/stereo_match.hpp"

namespace graspctx {

/// A three-fingered hand in a pinch grasp: a thumb against two parallel fingers. Defaults: a Barrett hand.
struct GRASPCTX_EXPORT HandOptions {
  double max_opening_m = 0.20;     // largest distance between the pads
  double opening_margin_m = 0.02;  // on either side of the part
  double finger_length_m = 0.126;  // palm to tip
  double finger_width_m = 0.018;
  double finger_thickness_m = 0.016;
  double finger_spread_m = 0.032;  // between the axes of the two fingers
  double palm_radius_m = 0.045;
  double tip_beyond_m = 0.006;  // fingertips reach this far past the grasp point
  double table_clearance_m = 0.001;
  double retreat_m = 0.10;  // the hand must also be clear of the table this far back
  void check() const;
};

enum class ApproachRule { plane_normal, major_axis, minor_axis };  // the three cases of III-D, Eq. 3
/// "plane_normal", "major_axis" or "minor_axis".
GRASPCTX_EXPORT const char* name_of(ApproachRule rule);

/// A full grasp configuration in the camera frame. Hand frame: z = approach (palm towards the object),
/// x = closing (from thumb to fingers), y = z × x; origin at the grasp point, between the pads.
struct GraspConfiguration {
  int rank = 0;    // from 1, in its object
  int patch = -1;  // of the left foveal view: its row in the object's PatchDescriptors
  double probability = 0, probability_left = 0, probability_right = 0;  // Eq. 1: P = P_left · P_right
  Eigen::Vector2d left_px{0, 0}, right_px{0, 0};
  Eigen::Vector3d position_m{0, 0, 0}, position_stddev_m{0, 0, 0};
  ApproachRule rule = ApproachRule::plane_normal;
  Eigen::Vector3d approach{0, 0, 0}, closing{0, 0, 0};
  Eigen::Matrix4d cam_from_hand = Eigen::Matrix4d::Identity();
  double opening_m = 0;
  bool feasible = true;
  std::optional<std::string> infeasible_because;
};

/// Approach and wrist by the paper's rule (III-D, Eq. 3), signed so that the hand comes from outside.
struct ApproachAndWrist {
  ApproachRule rule = ApproachRule::plane_normal;
  Eigen::Vector3d approach, closing;  // unit, orthogonal
};
/// `threshold` is φ as a share of the minor semi-axis in the image.
GRASPCTX_EXPORT ApproachAndWrist approach_and_wrist(const Eigen::Vector2d& grasp_px, const ObjectPose& pose,
                                                    double threshold = 0.3);
/// One case of the rule, whether or not the point selects it.
GRASPCTX_EXPORT ApproachAndWrist approach_by_rule(ApproachRule rule, const Eigen::Vector2d& grasp_px,
                                                  const ObjectPose& pose);

/// Why the hand would come through the table, or nothing if it does not.
GRASPCTX_EXPORT std::optional<std::string> table_conflict(const Eigen::Matrix4d& cam_from_hand,
                                                          double opening_m, const TablePlane& table,
                                                          const HandOptions& hand = {});

/// Position, approach, wrist and opening at a matched point of the left image (III-D): the paper's rule
/// first, and where that would take the hand through the table the other cases of the rule. Probabilities and
/// rank are the caller's to fill in. `mask` is CV_8UC1, > 0 = object, of the left image.
GRASPCTX_EXPORT GraspConfiguration configure_grasp(const Eigen::Vector2d& left_px, const StereoMatch& match,
                                                   const cv::Mat& mask, const StereoCamera& camera,
                                                   const ObjectPose& pose,
                                                   const std::optional<TablePlane>& table,
                                                   const HandOptions& hand = {}, double threshold = 0.3);

}  // namespace graspctx
