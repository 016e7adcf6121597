#pragma once
#include <opencv2/core.hpp>

#include "graspctx/camera.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// Height (m, CV_32FC1) above the table of what is seen at each pixel, from its disparity minus the table's
/// (CV_32FC1); NaN where that is unknown, or no point before the camera.
cv::Mat heights_over_plane(const cv::Mat& residual_px, const TablePlane& plane, const StereoCamera& camera);

}  // namespace graspctx::detail
