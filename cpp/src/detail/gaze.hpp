#pragma once
#include <opencv2/core.hpp>
#include <vector>

#include "detail/hypothesis.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// Of the hypotheses the one that the caller looks at, SegmentationOptions::fixation_px, roi_px or both; all
/// of them where the caller does not say. The seeds keep to the box. Where the hypotheses leave the pixel or
/// the box out, a new one from the steps in depth there. table: CV_8UC1 of the image's size, > 0 on the table
/// or below it, which is no object; empty if there is no table.
std::vector<Hypothesis> looked_at(std::vector<Hypothesis> hypotheses, const cv::Mat& table,
                                  const RectifiedPair& pair, const Disparity& disparity,
                                  const StereoCamera& camera, const SegmentationOptions& options);

}  // namespace graspctx::detail
