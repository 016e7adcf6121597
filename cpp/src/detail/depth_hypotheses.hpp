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

/// Beside a step in depth the right view does not see a strip of the ground as wide as the step in disparity:
/// it gets the ground's disparity. disparity: CV_32FC1 in px, of cells of cell_px.
cv::Mat without_hidden_strips(const cv::Mat& disparity, int cell_px = 1);

/// Peripheral view without a plane: the gaze goes through the depths, and finds pieces of one depth that end
/// in steps, most salient first.
std::vector<Hypothesis> hypotheses_by_disparity(const RectifiedPair& pair, const Disparity& disparity,
                                                const StereoCamera& camera,
                                                const SegmentationOptions& options);

/// Drops the hypotheses on a wall that most of the scene lies on: what it explains as well as they do.
void drop_parts_of_wall(const RectifiedPair& pair, const Disparity& disparity, const StereoCamera& camera,
                        double max_extent_m, std::vector<Hypothesis>& hypotheses);

/// What the gaze rests on before it knows the object's outline.
constexpr double gaze_m = 0.01;

/// A disc of this radius at this disparity, CV_8UC1 of the image's size, 255 inside.
cv::Mat disc_around(const cv::Point& centre, double radius_m, double disparity_px, const cv::Size& size,
                    const StereoCamera& camera);

/// The gaze is given: what surrounds this pixel of the left view at its depth, between steps in depth where
/// there are any. Nothing where no disparity is known around it.
std::optional<Hypothesis> hypothesis_at(const cv::Point& fixation, const Disparity& disparity,
                                        const StereoCamera& camera, const SegmentationOptions& options);

}  // namespace graspctx::detail
