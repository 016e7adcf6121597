#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace graspctx::detail {

/// A plane of any direction in a disparity map: d = coefficients · (u, v, 1).
struct BackgroundPlane {
  Eigen::Vector3d coefficients;
  int pixels = 0;  // about as many lie on it

  double disparity_px(double u, double v) const { return coefficients.dot(Eigen::Vector3d(u, v, 1)); }
};

/// The planes that the larger part of the known disparities lie on, the largest first: walls and floors.
/// `disparity_px` is CV_32FC1, NaN where unknown. A plane holds at least `least_share` of what is known.
std::vector<BackgroundPlane> background_planes(const cv::Mat& disparity_px, double least_share, int most);

}  // namespace graspctx::detail
