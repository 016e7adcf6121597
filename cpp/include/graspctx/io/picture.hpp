#pragma once
#include <opencv2/core.hpp>

#include "graspctx/detector.hpp"
#include "graspctx/export.hpp"

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

}  // namespace graspctx
