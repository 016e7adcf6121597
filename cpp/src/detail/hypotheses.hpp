#pragma once
#include <opencv2/core.hpp>
#include <vector>

#include "detail/relief.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// Where an object may be: pixels that are surely its own.
struct Hypothesis {
  cv::Mat seeds;            // CV_8UC1 of the image's size, 255 = the hypothesis
  double disparity_px = 0;  // median, where the view is fixated
  double saliency = 0;
};

/// Peripheral view without a plane: what is nearer than its surroundings in its row, most salient first.
std::vector<Hypothesis> hypotheses_by_disparity(const cv::Mat& disparity, const StereoCamera& camera,
                                                const SegmentationOptions& options);

/// What stands on the table, from a bird's-eye view of the relief, most salient first.
std::vector<Hypothesis> hypotheses_on_table(const RectifiedPair& pair, const Relief& relief,
                                            const TablePlane& plane, const StereoCamera& camera,
                                            const SegmentationOptions& options);

}  // namespace graspctx::detail
