#pragma once
// How well masks agree, and how well an object was found.
#include <algorithm>
#include <opencv2/core.hpp>

#include "graspctx/segmentation.hpp"
#include "ray_cast.hpp"

namespace graspctx::testing {

/// Intersection over union; 0 for two empty masks.
inline double iou(const cv::Mat& a, const cv::Mat& b) {
  return static_cast<double>(cv::countNonZero(a & b)) / std::max(1, cv::countNonZero(a | b));
}

/// Best overlap of a true mask with a found object.
inline double overlap(const cv::Mat& truth, const Segmentation& found) {
  double best = 0;
  for (const ObjectHypothesis& object : found.objects) {
    best = std::max(best, iou(truth, found.instance_ids == object.id));
  }
  return best;
}

inline double overlap(const CastScene& scene, int true_id, const Segmentation& found) {
  return overlap(scene.instance_ids == true_id, found);
}

}  // namespace graspctx::testing
