#pragma once
#include <opencv2/core.hpp>

#include "graspctx/detector.hpp"
#include "graspctx/export.hpp"

namespace graspctx {

struct GRASPCTX_EXPORT PictureOptions {
  int max_grasps = 3;         // hands drawn for each object
  bool contour = true;        // contour samples
  bool probabilities = true;  // patches coloured by P(g = 1 | D)
  int min_width_px = 960;     // smaller images are enlarged
};

/// Overlay of the rectified left view: segments, contour samples, patch probabilities and the ranked grasps,
/// each hand in perspective: axes (x closing red, z approach blue), thumb and two fingers. CV_8UC3 BGR.
GRASPCTX_EXPORT cv::Mat draw_detection(const Detection& detection, const StereoCamera& camera,
                                       const PictureOptions& options = {});

}  // namespace graspctx
