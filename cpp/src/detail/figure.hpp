#pragma once
#include <opencv2/core.hpp>

#include "detail/hypothesis.hpp"
#include "graspctx/camera.hpp"

namespace graspctx::detail {

/// The whole object that a hypothesis is a part of, CV_8UC1 of the image's size, 255 = object; one function
/// for each cue level. Empty or all 0 if there is none.

/// III-A, Fig. 2a: the view is fixated on the hypothesis, so that it has zero disparity, and the figure grows
/// by continuity in depth: a watershed on the disparity between what is at zero and what is far from it.
cv::Mat figure_at_zero_disparity(const Hypothesis& hypothesis, const cv::Mat& disparity,
                                 const StereoCamera& camera);

/// III-A, Fig. 2b: what does not belong to the plane. Where nothing is known inside the hypothesis' hull,
/// what is nearer to the hypothesis than to known ground or another hypothesis is its own.
cv::Mat figure_off_plane(const Hypothesis& hypothesis, const cv::Mat& known_ground, const cv::Mat& others);

/// III-A, Fig. 2c: depth and colour together, in a region around the hypothesis. known_ground: pixels that
/// lie on the table, or far from the object's depth; others: pixels of other hypotheses; table_odds: see
/// odds_of_table, empty without a table.
cv::Mat figure_by_colour(const Hypothesis& hypothesis, const cv::Mat& image, const cv::Mat& known_ground,
                         const cv::Mat& others, const cv::Mat& table_odds);

}  // namespace graspctx::detail
