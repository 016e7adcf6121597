#pragma once
#include <opencv2/core.hpp>

#include "detail/relief.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// CV_32FC1: how badly the plane explains what both views show of each pixel: squared colour difference in
/// units of its variance, 9 at most; -1 outside the right view.
cv::Mat misfit_of_table(const Relief& relief, const TablePlane& plane);

/// CV_32FC1: log of P(object) / P(table) from how much better the disparity of the nearest seed explains each
/// pixel than the table's; 0 where neither is said. It looks at single pixels, where matching smooths over
/// narrow gaps between raised parts, such as a handle's. For the object only seeds speak that their own
/// disparity explains to the noise, such as an inside of the table's colour: table next to an object is
/// hidden from the right camera.
cv::Mat odds_of_table(const Relief& relief, const TablePlane& plane, const cv::Mat& seeds);

}  // namespace graspctx::detail
