#pragma once
#include <opencv2/core.hpp>

#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// What stands out of the table.
struct Relief {
  cv::Mat residual_px;  // CV_32FC1: disparity minus the table's, NaN where unknown
  cv::Mat table_view;   // what the left view would show of the right one if all of it were table
  cv::Mat inside;       // CV_8UC1, 255 where the table's point lies inside the right view
};

/// Second pass of matching, at full resolution, on a right view warped by the plane: the table has zero
/// disparity everywhere, a few pixels of search are enough, and low objects stand out of it. What is higher
/// than that search keeps the disparity of the first pass.
Relief relief_over_plane(const RectifiedPair& pair, const Disparity& disparity, const TablePlane& plane);

}  // namespace graspctx::detail
