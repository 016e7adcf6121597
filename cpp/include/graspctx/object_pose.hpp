#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "graspctx/camera.hpp"
#include "graspctx/export.hpp"
#include "graspctx/fovea.hpp"
#include "graspctx/segmentation.hpp"
#include "graspctx/stereo_match.hpp"

namespace graspctx {

/// A rough object pose (III-D): the plane through three matched points of the segment.
struct ObjectPose {
  enum class Source { stereo, segment_depth };  // segment_depth: some point matched badly
  Eigen::Vector3d centroid_m{0, 0, 0};
  Eigen::Vector3d major_axis_m{0, 0, 0},
      minor_axis_m{0, 0, 0};        // a_ma, a_mi: from the centroid to the axis points
  Eigen::Vector3d normal{0, 0, 0};  // n_p, unit, towards the camera
  Eigen::Vector2d centroid_px{0, 0}, major_px{0, 0}, minor_px{0, 0};  // the three points, left image
  Source source = Source::stereo;
};

/// Ellipse of the segment, three points, each matched and triangulated; axes from both ends, pulled in to 85
/// %. Aligned with the table where there is one: a flat object takes the table's normal, an upright one
/// stands. Nothing if the segment has no depth at all. `mask` is CV_8UC1, > 0 = object, of the left image;
/// `disparity` CV_32FC1, NaN where unknown.
GRASPCTX_EXPORT std::optional<ObjectPose> estimate_object_pose(const FovealPair& pair, const cv::Mat& mask,
                                                               const cv::Mat& disparity,
                                                               const StereoCamera& camera,
                                                               const std::optional<TablePlane>& table);

}  // namespace graspctx
