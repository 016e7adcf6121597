#pragma once
#include <opencv2/core.hpp>
#include <optional>
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

/// What stands on the table, from a bird's-eye view of the relief, most salient first.
std::vector<Hypothesis> hypotheses_on_table(const RectifiedPair& pair, const Relief& relief,
                                            const TablePlane& plane, const StereoCamera& camera,
                                            const SegmentationOptions& options);

}  // namespace graspctx::detail
