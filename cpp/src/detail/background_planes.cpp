#include "detail/background_planes.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "detail/plane_of_three.hpp"

namespace graspctx::detail {

namespace {

constexpr int step_px = 3;  // of the samples
constexpr double within_px = 0.75;

struct Sample {
  double u, v, disparity_px;
};

std::vector<Sample> samples_of(const cv::Mat& disparity_px) {
  std::vector<Sample> samples;
  for (int v = step_px / 2; v < disparity_px.rows; v += step_px) {
    for (int u = step_px / 2; u < disparity_px.cols; u += step_px) {
      const float d = disparity_px.at<float>(v, u);
      if (!std::isnan(d)) samples.push_back({double(u), double(v), d});
    }
  }
  return samples;
}

double error_px(const Eigen::Vector3d& plane, const Sample& sample) {
  return std::abs(plane[0] * sample.u + plane[1] * sample.v + plane[2] - sample.disparity_px);
}

int support(const Eigen::Vector3d& plane, const std::vector<Sample>& samples, std::size_t every) {
  int count = 0;
  for (std::size_t i = 0; i < samples.size(); i += every) count += error_px(plane, samples[i]) < within_px;
  return count;
}

/// Least squares over what lies on the plane.
Eigen::Vector3d refined(Eigen::Vector3d plane, const std::vector<Sample>& samples) {
  constexpr int iterations = 3;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
    for (const Sample& sample : samples) {
      if (error_px(plane, sample) >= within_px) continue;
      const Eigen::Vector3d row(sample.u, sample.v, 1);
      normal_matrix += row * row.transpose();
      right_side += sample.disparity_px * row;
    }
    const Eigen::Vector3d next = normal_matrix.ldlt().solve(right_side);
    if (!next.allFinite()) break;
    plane = next;
  }
  return plane;
}

std::optional<Eigen::Vector3d> largest_plane(const std::vector<Sample>& samples) {
  constexpr int draws = 200;
  constexpr std::size_t looked_at = 600;
  const std::size_t every = samples.size() / looked_at + 1;
  std::mt19937 random(20090512);  // fixed: the same view always gives the same planes
  std::optional<Eigen::Vector3d> best;
  int most = 0;
  for (int draw = 0; draw < draws; ++draw) {
    const auto drawn_through = plane_of_three(samples, random);
    if (!drawn_through) continue;
    const Eigen::Vector3d& plane = *drawn_through;
    const int count = support(plane, samples, every);
    if (count > most) {
      most = count;
      best = plane;
    }
  }
  return best;
}

}  // namespace

std::vector<BackgroundPlane> background_planes(const cv::Mat& disparity_px, double least_share, int most) {
  constexpr std::size_t least_samples = 100;
  std::vector<BackgroundPlane> planes;
  std::vector<Sample> samples = samples_of(disparity_px);
  const auto least = std::max(static_cast<double>(least_samples), least_share * double(samples.size()));
  while (static_cast<int>(planes.size()) < most && static_cast<double>(samples.size()) >= least) {
    const auto drawn = largest_plane(samples);
    if (!drawn) break;
    const Eigen::Vector3d plane = refined(*drawn, samples);
    const int count = support(plane, samples, 1);
    if (count < least) break;
    planes.push_back({plane, count * step_px * step_px});
    const auto lies_on_it = [&](const Sample& sample) { return error_px(plane, sample) < within_px; };
    samples.erase(std::remove_if(samples.begin(), samples.end(), lies_on_it), samples.end());
  }
  return planes;
}

}  // namespace graspctx::detail
