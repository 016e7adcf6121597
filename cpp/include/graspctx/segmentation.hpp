#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "graspctx/camera.hpp"
#include "graspctx/export.hpp"
#include "graspctx/stereo.hpp"

namespace graspctx {

/// Cue levels of III-A, Fig. 2; each adds to the one before.
enum class CueLevel {
  disparity,  // zero disparity and continuity in depth (Fig. 2a)
  plane,      // + the dominant plane (Fig. 2b)
  colour,     // + hue (Fig. 2c)
};
/// "disparity", "plane" or "colour".
GRASPCTX_EXPORT const char* name_of(CueLevel level);

/// The supporting plane. In the image: d = alpha·u + beta·v + delta (III-A). In the camera frame:
/// normal·P + offset_m = 0 on the plane, and is the height (m) above it elsewhere; the unit normal points
/// from the plane to the camera, so that offset_m > 0 is the camera's own height.
struct TablePlane {
  double alpha = 0, beta = 0, delta_px = 0;
  Eigen::Vector3d normal{0, 0, 0};
  double offset_m = 0;
  double sigma_px = 0;  // robust standard deviation of the disparities around the plane
  double height_m(const Eigen::Vector3d& point_m) const { return normal.dot(point_m) + offset_m; }
};

struct ObjectHypothesis {
  int id = 0;  // its value in Segmentation::instance_ids, from 1
  cv::Rect bounding_box_px;
  Eigen::Vector2d centroid_px{0, 0};
  /// What is large and in reach is looked at first: the area that is surely seen of it (cm², square to the
  /// view) over its distance (m); of a caller's own mask its pixels. The hypotheses are ordered by it.
  double saliency = 0;
  bool touches_border = false;  // cut by the image
  /// Part of it stands or hangs beyond the table's edge, where that edge is seen. False without a plane.
  bool leaves_table = false;
  /// Length and width (length >= width) of what is seen of it from right above, and its height over the
  /// table. The far side is not seen: a box is longer than that by what it hides. Nothing without a plane, or
  /// if hardly any of its depth is known.
  std::optional<Eigen::Vector3d> size_m;
  std::optional<double> depth_m;  // median over its pixels; nothing where no disparity is known
};

struct GRASPCTX_EXPORT SegmentationOptions {
  CueLevel cues = CueLevel::colour;
  int max_objects = 8;
  double min_height_m = 0.006, max_height_m = 0.40;  // of an object's top above the table
  double min_extent_m = 0.008, max_extent_m = 0.45;  // along the table
  double min_reliable_share =
      0.5;                // of the textured pixels; below, the pair is no stereo pair and holds no object
  double cell_m = 0.005;  // level plane: from right above, parts farther apart than two are two objects
  std::optional<Eigen::Vector2d> fixation_px;  // look at the object at this pixel of the left view only
  /// Look only at the object in this box of the left view, and cut it off at the box.
  std::optional<cv::Rect> roi_px;
  /// The table of a rig that does not move: its unit normal and offset_m are used as they are, the rest is
  /// not read.
  std::optional<TablePlane> table;
  /// The direction in which things fall, in the camera frame, of any length > 0 (an accelerometer at rest
  /// shows its opposite). A level plane is looked for instead of one below an upright camera.
  std::optional<Eigen::Vector3d> gravity;
  void check() const;
};

struct Segmentation {
  cv::Mat instance_ids;  // CV_8UC1, 0 = background, otherwise ObjectHypothesis::id
  std::optional<TablePlane> table;
  cv::Mat heights_m;  // CV_32FC1: above the table, NaN where unknown; empty without a table
  std::vector<ObjectHypothesis> objects;
  /// How much lower the scene lies in the right view than in the left one, in the middle of the image: about
  /// 0 if the views are rectified well. Nothing if too little is seen alike in both views.
  std::optional<double> vertical_offset_px;
  std::vector<std::string> warnings;
};

/// Find the objects of a scene without knowing what they are (III-A). No object is an answer.
GRASPCTX_EXPORT Segmentation segment_objects(const RectifiedPair& pair, const Disparity& disparity,
                                             const StereoCamera& camera,
                                             const SegmentationOptions& options = {});

/// The supporting plane alone: options.table where it is known, otherwise a robust fit (RANSAC, Tukey,
/// photometric refinement). A table is level within 15° where options.gravity says how things fall. Without
/// it the camera is taken to be about upright, and only a plane that it looks down on by 8° to 75°, rolled by
/// at most 35°, is a table: a wall is not, nor a table seen from right above. A table without texture is
/// fitted from below to its own border, shadows and what touches it. Nothing if no such plane supports
/// anything, or if what is seen does not tell its angle and height: a wrong plane is worse than none. Of the
/// options only table, gravity and max_height_m are used.
GRASPCTX_EXPORT std::optional<TablePlane> fit_table_plane(const RectifiedPair& pair,
                                                          const Disparity& disparity,
                                                          const StereoCamera& camera,
                                                          const SegmentationOptions& options = {});

/// The object before a plain, light background, from one image (CV_8UC3 BGR or CV_8UC1): CV_8UC1, 255 =
/// object, all 0 if nothing stands out. The background is what has the colour of the image's border,
/// brightness falling off across the image and soft shadows included; it shows through holes such as a
/// handle's. Parts that touch the border are not the object unless there is nothing else.
GRASPCTX_EXPORT cv::Mat plain_background_mask(const cv::Mat& image);

/// Hypotheses from a caller's own instance mask: CV_8UC1 of the image's size, each value > 0 one object.
/// Throws InvalidInput for another type or size. An all-zero mask holds no object.
GRASPCTX_EXPORT Segmentation segmentation_from_mask(const cv::Mat& instance_ids, const cv::Size& image_size);

}  // namespace graspctx
