#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace graspctx::detail {

/// Whether a sample, by its offset from a patch's centre, lies in a window of that side. Half open, as the
/// patches of the grid are.
inline bool is_in_window(const cv::Point2f& offset_px, int side_px) {
  const float half_px = 0.5f * static_cast<float>(side_px);
  return offset_px.x >= -half_px && offset_px.x < half_px && offset_px.y >= -half_px && offset_px.y < half_px;
}

/// L1 norm, then the square root of each entry (Hellinger).
inline void normalise(Eigen::Ref<Eigen::RowVectorXf> histogram) {
  const float sum = histogram.sum();
  if (sum > 0) histogram = (histogram / sum).cwiseSqrt();
}

}  // namespace graspctx::detail
