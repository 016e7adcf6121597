#pragma once
#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "graspctx/camera.hpp"

namespace graspctx::detail {

/// Where an object may be: pixels that are surely its own.
struct Hypothesis {
  cv::Mat seeds;            // CV_8UC1 of the image's size, 255 = the hypothesis
  double disparity_px = 0;  // median, where the view is fixated
  double saliency = 0;
};

/// See ObjectHypothesis::saliency.
inline double saliency_of(double area_px, double disparity_px, const StereoCamera& camera) {
  const double distance_m = camera.depth_m(disparity_px), side_cm = 100 * distance_m / camera.focal_px;
  return area_px * side_cm * side_cm / distance_m;
}

/// The most salient first; equals keep their order.
inline void sort_by_saliency(std::vector<Hypothesis>& hypotheses) {
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const auto& a, const auto& b) { return a.saliency > b.saliency; });
}

}  // namespace graspctx::detail
