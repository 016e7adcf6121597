#pragma once
#include <map>
#include <opencv2/core.hpp>

#include "graspctx/detector.hpp"
#include "graspctx/explanation.hpp"
#include "graspctx/export.hpp"
#include "graspctx/segmentation.hpp"
#include "graspctx/stereo.hpp"

namespace graspctx {

struct GRASPCTX_EXPORT PictureOptions {
  int max_grasps = 3;         // drawn for each object: a hand for the first, a mark for the others
  bool contour = true;        // contour samples
  bool probabilities = true;  // patches coloured by P(g = 1 | D)
  bool pose = true;           // the plane of the object's pose and its two axes (Fig. 4)
  int min_width_px = 960;     // smaller images are enlarged
  HandOptions hand;           // the hand that is drawn
  void check() const;
};

/// Overlay of the rectified left view: segments, contour samples, patch probabilities and the ranked grasps,
/// in perspective: axes (x closing red, y green, z approach blue), the palm, the thumb and two fingers of the
/// best, grey where infeasible. Parts behind the camera are left out. CV_8UC3 BGR. Throws InvalidInput if the
/// detection holds no image or an option is out of range.
GRASPCTX_EXPORT cv::Mat draw_detection(const Detection& detection, const StereoCamera& camera,
                                       const PictureOptions& options = {});

/// One picture that explains a grasp: the object's foveal view with the contour samples coloured by their
/// effect (blue speaks for a grasping point, orange against), the patch and its three windows; beside it the
/// log-polar bins of each window, as seen in the image; below, the nearest training images, drawn where
/// NearImage::patch is there and named otherwise. CV_8UC3 BGR.
GRASPCTX_EXPORT cv::Mat draw_explanation(const GraspExplanation& explanation);

/// One picture that explains how a scene was segmented (III-A, Fig. 2), in eight panels: the hypotheses of
/// the level that options.cues names, the disparity, a grid on the table plane, the heights above it, the
/// three cue levels side by side, and the objects in numbers. levels: what segment_objects gave for the same
/// pair at each level; those that are missing are left empty. options: those the levels were made with; its
/// fixation point and region are drawn. panel_px: the longer side of each panel, 160 to 4096. CV_8UC3 BGR.
/// Throws InvalidInput for maps and masks of another size than the image, or if the level of options.cues is
/// missing.
GRASPCTX_EXPORT cv::Mat draw_segmentation(const cv::Mat& left, const Disparity& disparity,
                                          const StereoCamera& camera,
                                          const std::map<CueLevel, Segmentation>& levels,
                                          const SegmentationOptions& options = {}, int panel_px = 640);

}  // namespace graspctx
