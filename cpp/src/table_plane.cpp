#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "detail/masks.hpp"
#include "detail/outline_match.hpp"
#include "detail/plain_table.hpp"
#include "detail/plain_table_plane.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/plane_of_three.hpp"
#include "detail/quantile.hpp"
#include "detail/scene_checks.hpp"
#include "detail/table_fit.hpp"
#include "detail/texture.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx {

namespace {

using Coefficients = Eigen::Vector3d;  // alpha, beta, delta

struct Sample {
  double u, v, disparity_px;
};

double residual(const Coefficients& plane, const Sample& sample) {
  return sample.disparity_px - (plane[0] * sample.u + plane[1] * sample.v + plane[2]);
}

/// Known disparities on a grid, about `wanted` of them.
std::vector<Sample> grid_samples(const cv::Mat& disparity, double wanted) {
  const int step = std::max(1, static_cast<int>(std::sqrt(disparity.total() / wanted)));
  std::vector<Sample> samples;
  for (int v = step / 2; v < disparity.rows; v += step) {
    const auto* row = disparity.ptr<float>(v);
    for (int u = step / 2; u < disparity.cols; u += step) {
      if (!std::isnan(row[u])) samples.push_back({double(u), double(v), row[u]});
    }
  }
  return samples;
}

/// Tables are level. Without gravity: a table rises towards the horizon, and an upright camera looks down on
/// it neither along it nor like at a wall.
bool looks_like_a_table(const TablePlane& plane, const std::optional<Eigen::Vector3d>& gravity) {
  constexpr double degree = CV_PI / 180;
  const Eigen::Vector3d up = plane.normal;  // y points down in the image
  if (!up.allFinite()) return false;
  if (gravity) return up.dot(-gravity->normalized()) >= std::cos(15 * degree);
  if (up.y() >= 0) return false;
  const double elevation = std::asin(std::clamp(-up.z(), -1.0, 1.0));
  const double roll = std::atan2(up.x(), -up.y());
  return elevation >= 8 * degree && elevation <= 75 * degree && std::abs(roll) <= 35 * degree;
}

constexpr double inlier_px = 1.0;
constexpr double below_px = 8.0;

/// What lies on the plane counts for it, what lies just below it against it: nothing is seen through a table.
double support(const Coefficients& plane, const std::vector<Sample>& samples) {
  double sum = 0;
  for (const Sample& sample : samples) {
    const double e = residual(plane, sample) / inlier_px;
    if (std::abs(e) < 1) {
      sum += 1 - e * e;
    } else if (e < -2 && e > -below_px) {
      sum -= 0.5;
    }
  }
  return sum;
}

std::optional<Coefficients> ransac(const std::vector<Sample>& samples, const StereoCamera& camera,
                                   const std::optional<Eigen::Vector3d>& gravity) {
  constexpr int draws = 600;
  std::mt19937 random(20090512);  // fixed: the same scene always gives the same plane
  std::optional<Coefficients> best;
  double best_support = 0;
  for (int draw = 0; draw < draws; ++draw) {
    const auto drawn_through = detail::plane_of_three(samples, random);
    if (!drawn_through) continue;
    const Eigen::Vector3d& plane = *drawn_through;
    if (!looks_like_a_table(detail::plane_from_disparity(plane, camera), gravity)) continue;
    const double s = support(plane, samples);
    if (s > best_support) {
      best_support = s;
      best = plane;
    }
  }
  return best;
}

/// Robust standard deviation of the residuals within `within_px` of the plane.
double spread_px(const Coefficients& plane, const std::vector<Sample>& samples, double within_px) {
  std::vector<double> errors;
  for (const Sample& sample : samples) {
    const double e = std::abs(residual(plane, sample));
    if (e < within_px) errors.push_back(e);
  }
  constexpr double floor_px = 0.05;
  return errors.empty() ? floor_px : std::max(floor_px, 1.4826 * detail::median(std::move(errors)));
}

/// Tukey's M-estimator by re-weighted least squares.
Coefficients refine_on_disparities(Coefficients plane, const std::vector<Sample>& samples) {
  for (int iteration = 0; iteration < 10; ++iteration) {
    const double cut_off = 4.685 * spread_px(plane, samples, 2 * inlier_px);
    Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
    for (const Sample& sample : samples) {
      const double e = residual(plane, sample) / cut_off;
      if (std::abs(e) >= 1) continue;
      const double weight = (1 - e * e) * (1 - e * e);
      const Eigen::Vector3d row(sample.u, sample.v, 1);
      normal_matrix += weight * row * row.transpose();
      right_side += weight * sample.disparity_px * row;
    }
    const Coefficients next = normal_matrix.ldlt().solve(right_side);
    if (!next.allFinite()) break;
    plane = next;
  }
  return plane;
}

/// Grey levels without their local mean: the two cameras may differ in brightness.
cv::Mat without_local_mean(const cv::Mat& image) {
  cv::Mat values, mean;
  detail::grey(image).convertTo(values, CV_32F);
  cv::boxFilter(values, mean, CV_32F, {21, 21}, {-1, -1}, true, cv::BORDER_REFLECT_101);
  return values - mean;
}

float sampled(const float* row, double u) {
  const int whole = static_cast<int>(u);
  const auto part = static_cast<float>(u - whole);
  return row[whole] + part * (row[whole + 1] - row[whole]);
}

/// The plane that brings the two views of the table onto each other: Gauss–Newton on grey differences, Huber
/// weights. Matching finds disparities to a third of a pixel, a whole plane of grey levels to a hundredth.
Coefficients refine_on_grey_levels(const Coefficients& start, const RectifiedPair& pair,
                                   const cv::Mat& disparity, double sigma_px) {
  const cv::Mat left = without_local_mean(pair.left), right = without_local_mean(pair.right);
  const double within_px = std::max(1.0, 3 * sigma_px);
  Coefficients plane = start;
  for (int iteration = 0; iteration < 12; ++iteration) {
    double huber = 0;
    Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
    struct Row {
      double slope, difference, u, v;
    };
    std::vector<Row> rows;
    std::vector<double> sizes;
    for (int v = 1; v < left.rows; v += 2) {
      const auto* l = left.ptr<float>(v);
      const auto* r = right.ptr<float>(v);
      const auto* d = disparity.ptr<float>(v);
      for (int u = 1; u + 1 < left.cols; u += 2) {
        const double on_start = start[0] * u + start[1] * v + start[2];
        // An unknown disparity may be the table's as well.
        if (!std::isnan(d[u]) && std::abs(d[u] - on_start) > within_px) continue;
        const double u_right = u - (plane[0] * u + plane[1] * v + plane[2]);
        if (u_right < 1 || u_right >= left.cols - 2) continue;
        const double slope = 0.25 * (l[u + 1] - l[u - 1] + sampled(r, u_right + 1) - sampled(r, u_right - 1));
        rows.push_back({slope, l[u] - sampled(r, u_right), double(u), double(v)});
        sizes.push_back(std::abs(rows.back().difference));
      }
    }
    if (rows.size() < 100) return start;
    huber = std::max(0.5, 1.5 * 1.4826 * detail::median(std::move(sizes)));
    for (const Row& row : rows) {
      // left(u) - right(u - d) grows by slope · step when d grows by step.
      const double weight = std::abs(row.difference) <= huber ? 1 : huber / std::abs(row.difference);
      const Eigen::Vector3d gradient = row.slope * Eigen::Vector3d(row.u, row.v, 1);
      normal_matrix += weight * gradient * gradient.transpose();
      right_side -= weight * row.difference * gradient;
    }
    const Eigen::Vector3d step = normal_matrix.ldlt().solve(right_side);
    if (!step.allFinite()) return start;
    plane += step;
    if (std::abs(step[0]) * left.cols + std::abs(step[1]) * left.rows + std::abs(step[2]) < 1e-3) break;
  }
  // It is a refinement: a plane that leaves what the disparities say has slid along a texture.
  double largest_change = 0;
  for (const double u : {0.0, left.cols - 1.0}) {
    for (const double v : {0.3 * left.rows, left.rows - 1.0}) {
      largest_change = std::max(largest_change, std::abs((plane - start).dot(Eigen::Vector3d(u, v, 1))));
    }
  }
  return largest_change <= within_px + 1 ? plane : start;
}

/// The plane that most of the known disparities lie on.
std::optional<TablePlane> textured_plane(const RectifiedPair& pair, const cv::Mat& disparity,
                                         const StereoCamera& camera,
                                         const std::optional<Eigen::Vector3d>& gravity) {
  constexpr double wanted = 5000;
  const std::vector<Sample> few = grid_samples(disparity, wanted);
  if (few.size() < 50) return std::nullopt;
  const auto drawn = ransac(few, camera, gravity);
  if (!drawn) return std::nullopt;
  const std::vector<Sample> many = grid_samples(disparity, 40000);
  const Coefficients fitted = refine_on_disparities(*drawn, many);
  const double rough_sigma_px = spread_px(fitted, many, 2 * inlier_px);
  const Coefficients refined = refine_on_grey_levels(fitted, pair, disparity, rough_sigma_px);

  TablePlane plane = detail::plane_from_disparity(refined, camera);
  plane.sigma_px = spread_px(refined, many, 2 * inlier_px);
  if (!looks_like_a_table(plane, gravity)) return std::nullopt;
  // A plane that carries hardly anything of what is known, or is hardly seen, is no support: the edges of a
  // table without texture lie on many planes.
  constexpr double least_share_of_known = 0.2, least_share_of_image = 0.1;
  double on_plane = 0;
  for (const Sample& sample : few)
    on_plane += std::abs(residual(refined, sample)) < 3 * plane.sigma_px ? 1 : 0;
  if (on_plane <
      std::max(least_share_of_known * static_cast<double>(few.size()), least_share_of_image * wanted)) {
    return std::nullopt;
  }
  return plane;
}

/// A support that hovers level over a plane, higher than any object on it: then that is the floor.
std::optional<TablePlane> plane_above(const TablePlane& plane, const RectifiedPair& pair,
                                      const cv::Mat& disparity, const StereoCamera& camera,
                                      const SegmentationOptions& options) {
  cv::Mat hovering(disparity.size(), CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  for (int v = 0; v < disparity.rows; ++v) {
    for (int u = 0; u < disparity.cols; ++u) {
      const float d = disparity.at<float>(v, u);
      if (std::isnan(d) || !(detail::height_m(plane, camera, u, v, d) > options.max_height_m)) continue;
      hovering.at<float>(v, u) = d;
    }
  }
  const auto upper = textured_plane(pair, hovering, camera, options.gravity);
  const double level = std::cos(15 * CV_PI / 180);
  return upper && upper->normal.dot(plane.normal) >= level ? upper : std::nullopt;
}

/// Does stereo know a plain region nonetheless? What is plain to the eye may be a faint texture.
bool is_known(const detail::PlainTable& plain, const cv::Mat& disparity) {
  constexpr double most_known = 0.12;
  const cv::Mat inner = detail::shrunk(plain.region, 5),
                known = disparity == disparity;  // NaN is not itself
  return cv::countNonZero(known & inner) > most_known * cv::countNonZero(inner);
}

/// Does what is seen within a plain region hover over a plane, higher than any object? Then the region is a
/// support of its own, and the plane is the floor beneath.
bool is_beneath(const TablePlane& plane, const detail::PlainTable& plain, const cv::Mat& disparity,
                const StereoCamera& camera, double max_height_m) {
  const cv::Mat within = detail::grown(plain.extent, 4);
  int hovering = 0, known = 0;
  for (int v = 0; v < disparity.rows; ++v) {
    for (int u = 0; u < disparity.cols; ++u) {
      const float d = disparity.at<float>(v, u);
      if (std::isnan(d) || !within.at<uchar>(v, u)) continue;
      ++known;
      hovering += detail::height_m(plane, camera, u, v, d) > max_height_m ? 1 : 0;
    }
  }
  return known >= 50 && hovering > known / 2;
}

/// The plane of a table without texture; `floor` is a plane beneath it where one is known.
std::optional<TablePlane> plain_plane(const RectifiedPair& pair, const Disparity& disparity,
                                      const StereoCamera& camera, const detail::PlainTable& plain,
                                      const std::optional<Eigen::Vector3d>& gravity,
                                      const std::optional<TablePlane>& floor) {
  // Somewhat nearer than what the first pass knows.
  std::vector<float> known;
  for (const Sample& sample : grid_samples(disparity.reliable, 40000)) {
    known.push_back(static_cast<float>(sample.disparity_px));
  }
  if (known.empty()) return std::nullopt;
  const int most_px = static_cast<int>(1.25 * detail::quantile(known, 0.99)) + 8;
  const auto outline = detail::match_outline(pair, plain.region, most_px);
  const cv::Moments moments = cv::moments(plain.region, true);
  const Eigen::Vector2d centre_px(moments.m10 / moments.m00, moments.m01 / moments.m00);
  const auto is_support = [&](const TablePlane& plane) { return looks_like_a_table(plane, gravity); };
  auto plane = detail::plane_under_outline(outline, camera, centre_px, is_support);
  constexpr double sure_px = 0.8;  // of a floor whose angle can be relied on
  if (!plane && floor && floor->sigma_px < sure_px)
    plane = detail::level_plane_under_outline(outline, camera, floor->normal);
  if (!plane && gravity) plane = detail::level_plane_under_outline(outline, camera, -gravity->normalized());
  return plane;
}

}  // namespace

std::optional<TablePlane> detail::fit_table_plane(const RectifiedPair& pair, const Disparity& disparity,
                                                  const StereoCamera& camera,
                                                  const SegmentationOptions& options,
                                                  const std::optional<PlainTable>& plain) {
  if (options.table) {
    TablePlane known = plane_in_view(options.table->normal.normalized(), options.table->offset_m, camera);
    known.sigma_px = spread_px({known.alpha, known.beta, known.delta_px},
                               grid_samples(disparity.reliable, 5000), 2 * inlier_px);
    return known;
  }
  if (!plain || is_known(*plain, disparity.reliable)) {
    auto plane = textured_plane(pair, disparity.reliable, camera, options.gravity);
    // Of a faint table so little may be surely known that it is lost before a wall or a floor.
    if (!plane) plane = textured_plane(pair, disparity.dense, camera, options.gravity);
    if (!plane) return std::nullopt;
    const auto upper = plane_above(*plane, pair, disparity.reliable, camera, options);
    return upper ? upper : plane;
  }
  // Of the plain region the matcher knows the edges only, and those not well: they are for the outline.
  cv::Mat elsewhere = disparity.reliable.clone();
  elsewhere.setTo(std::numeric_limits<float>::quiet_NaN(), grown(plain->extent, 4));
  const auto textured = textured_plane(pair, elsewhere, camera, options.gravity);
  if (textured && !is_beneath(*textured, *plain, disparity.reliable, camera, options.max_height_m)) {
    return textured;
  }
  return plain_plane(pair, disparity, camera, *plain, options.gravity, textured);
}

std::optional<TablePlane> fit_table_plane(const RectifiedPair& pair, const Disparity& disparity,
                                          const StereoCamera& camera, const SegmentationOptions& options) {
  options.check();
  camera.check();
  detail::require_scene(pair, disparity);
  std::optional<detail::PlainTable> plain;
  if (!options.table) plain = detail::find_plain_table(pair.left);
  return detail::fit_table_plane(pair, disparity, camera, options, plain);
}

}  // namespace graspctx
