#pragma once
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detail/hypothesis.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// Half the width (px) of what counts as zero disparity in a view fixated at disparity + doffs = shifted_px:
/// a share of the depth.
double zero_disparity_band_px(double shifted_px);

/// Peripheral view without a plane: the gaze goes through the depths, and finds pieces of one depth that end
/// in steps, most salient first.
std::vector<Hypothesis> hypotheses_by_disparity(const Disparity& disparity, const StereoCamera& camera,
                                                const SegmentationOptions& options);

/// The gaze is given: what surrounds this pixel of the left view at its depth, between steps in depth where
/// there are any. Nothing where no disparity is known around it.
std::optional<Hypothesis> hypothesis_at(const cv::Point& fixation, const Disparity& disparity,
                                        const StereoCamera& camera, const SegmentationOptions& options);

}  // namespace graspctx::detail
