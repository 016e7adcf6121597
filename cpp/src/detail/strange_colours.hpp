#pragma once
#include <opencv2/core.hpp>
#include <vector>

#include "detail/hypothesis.hpp"
#include "detail/relief.hpp"
#include "detail/table_frame.hpp"
#include "graspctx/camera.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// Pieces of the table's area (CV_8UC1 masks) of a colour that the table has not, whose outline is seen over
/// the plane rather than on it: what is too thin or low for the matcher, such as a pencil. Prints and shadows
/// lie on the plane. `relief` gets the residual of the outline where a piece did not stand out before.
std::vector<cv::Mat> raise_strange_colours(const RectifiedPair& pair, const TablePlane& plane,
                                           const TableFrame& frame, const StereoCamera& camera,
                                           Relief& relief);

}  // namespace graspctx::detail
