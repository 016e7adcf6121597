#pragma once
#include <Eigen/Dense>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

namespace graspctx::detail {

/// The plane d = alpha u + beta v + delta through three samples drawn at random; none if they lie nearly in
/// line. A sample has u, v and disparity_px.
template <typename Sample>
std::optional<Eigen::Vector3d> plane_of_three(const std::vector<Sample>& samples, std::mt19937& random) {
  constexpr double least_parallelogram_px2 = 1000;
  Eigen::Matrix3d points;
  Eigen::Vector3d disparities;
  for (int i = 0; i < 3; ++i) {
    const Sample& sample = samples[random() % samples.size()];
    points.row(i) << sample.u, sample.v, 1;
    disparities[i] = sample.disparity_px;
  }
  if (std::abs(points.determinant()) < least_parallelogram_px2) return std::nullopt;
  return points.inverse() * disparities;
}

}  // namespace graspctx::detail
