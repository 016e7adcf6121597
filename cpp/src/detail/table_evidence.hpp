#pragma once
#include <opencv2/core.hpp>

#include "detail/relief.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// CV_32FC1: log of P(object) / P(table) from how much better the table's disparity explains each pixel than
/// that of the nearest seed; below 0 where it is the table, 0 elsewhere. It looks at single pixels, where
/// matching smooths over narrow gaps between raised parts, such as a handle's. It never speaks for the
/// object: table next to an object is hidden from the right camera and fits neither.
cv::Mat odds_of_table(const Relief& relief, const TablePlane& plane, const cv::Mat& seeds);

}  // namespace graspctx::detail
