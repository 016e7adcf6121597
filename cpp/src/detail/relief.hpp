#pragma once
#include <opencv2/core.hpp>

#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// What stands out of the table.
struct Relief {
  cv::Mat residual_px;  // CV_32FC1: disparity minus the table's, NaN where unknown
  cv::Mat sigma_px;     // CV_32FC1: its standard deviation, from the images' noise and local texture
  cv::Mat inside;       // CV_8UC1, 255 where the table's point lies inside the right view
  cv::Mat left, right;  // CV_32FC1 or CV_32FC3: the views, the right one as bright as the left
  double noise = 1;     // standard deviation of one channel, grey levels
};

/// Second pass of matching, at full resolution, on a right view warped by the plane: the table has zero
/// disparity everywhere, a few pixels of search are enough, and low objects stand out of it. A Gauss–Newton
/// step on colour differences then finds the fraction of a pixel, to which the matcher is nearly blind. What
/// is higher than that search keeps the disparity of the first pass.
Relief relief_over_plane(const RectifiedPair& pair, const Disparity& disparity, const TablePlane& plane);

/// The right view as the left camera would see it if every pixel had the residual given (CV_32FC1; NaN: 0)
/// over the plane.
cv::Mat right_view_over_plane(const cv::Mat& right, const TablePlane& plane, const cv::Mat& residual_px);

/// Sum over the channels, CV_32FC1.
cv::Mat channel_sum(const cv::Mat& image);

}  // namespace graspctx::detail
