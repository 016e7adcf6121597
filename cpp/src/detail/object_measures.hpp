#pragma once
#include <opencv2/core.hpp>

#include "detail/table_frame.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// Fills in what is known of an object from the table it stands on: ObjectHypothesis::size_m and
/// leaves_table. mask: CV_8UC1, 255 = the object; the relief is preferred to the disparity of the first pass.
void measure_on_table(ObjectHypothesis& object, const cv::Mat& mask, const Disparity& disparity,
                      const Relief& relief, const TablePlane& plane, const TableFrame& frame,
                      const StereoCamera& camera);

}  // namespace graspctx::detail
