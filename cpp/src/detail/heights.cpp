#include "detail/heights.hpp"

#include <limits>

#include "detail/plane_geometry.hpp"

namespace graspctx::detail {

cv::Mat heights_over_plane(const cv::Mat& residual_px, const TablePlane& plane, const StereoCamera& camera) {
  cv::Mat heights(residual_px.size(), CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  for (int v = 0; v < heights.rows; ++v) {
    const auto* residual = residual_px.ptr<float>(v);
    auto* height = heights.ptr<float>(v);
    for (int u = 0; u < heights.cols; ++u) {
      const double disparity_px = plane_disparity(plane, u, v) + residual[u];
      if (disparity_px + camera.doffs_px > 0) {  // false for NaN
        height[u] = static_cast<float>(height_m(plane, camera, u, v, disparity_px));
      }
    }
  }
  return heights;
}

}  // namespace graspctx::detail
