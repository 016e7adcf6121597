#include "detail/object_measures.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "detail/masks.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/quantile.hpp"

namespace graspctx::detail {

namespace {

constexpr float inner_share = 0.98F;  // mask and disparity are wrong here and there, mostly at the outline

std::pair<float, float> inner_range(const std::vector<float>& values) {
  return {quantile(values, (1 - inner_share) / 2), quantile(values, (1 + inner_share) / 2)};
}

/// Length and width of the smallest rectangle around what is left without the outermost points.
cv::Size2f footprint(const std::vector<cv::Point2f>& points) {
  const auto cut_to_range = [](const std::vector<cv::Point2f>& all, float angle_rad) {
    const float c = std::cos(angle_rad), s = std::sin(angle_rad);
    std::vector<float> along, across;
    for (const cv::Point2f& p : all) {
      along.push_back(c * p.x + s * p.y);
      across.push_back(c * p.y - s * p.x);
    }
    const auto [first, last] = inner_range(along);
    const auto [low, high] = inner_range(across);
    std::vector<cv::Point2f> kept;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (along[i] >= first && along[i] <= last && across[i] >= low && across[i] <= high)
        kept.push_back(all[i]);
    }
    return std::make_pair(kept, cv::Size2f(last - first, high - low));
  };
  const auto inner = cut_to_range(points, 0).first;
  const float angle_rad = cv::minAreaRect(inner).angle * static_cast<float>(CV_PI) / 180;
  const cv::Size2f size = cut_to_range(points, angle_rad).second;
  return {std::max(size.width, size.height), std::min(size.width, size.height)};
}

}  // namespace

void measure_on_table(ObjectHypothesis& object, const cv::Mat& mask, const Disparity& disparity,
                      const Relief& relief, const TablePlane& plane, const TableFrame& frame,
                      const StereoCamera& camera) {
  constexpr double beyond_edge_m = 0.015;  // the edge is not known better
  constexpr double rim_m = 0.003;          // lower is table that the mask took along
  const cv::Rect2d image(0, 0, mask.cols - 1, mask.rows - 1);
  std::vector<cv::Point2f> on_table;
  std::vector<float> heights_m;
  int beyond_edge = 0;
  const cv::Mat core = shrunk(mask, 1);  // the outline's own depth is of both sides of it
  const bool thin = cv::countNonZero(core) < 0.5 * cv::countNonZero(mask);
  const std::vector<cv::Point> pixels = where(thin ? mask : core);
  for (const cv::Point& p : pixels) {
    const double d_table = plane_disparity(plane, p.x, p.y);
    const float r = relief.residual_px.at<float>(p);
    const double d = std::isnan(r) ? disparity.reliable.at<float>(p) : d_table + r;
    if (std::isnan(d) || d + camera.doffs_px <= 0) continue;
    const Eigen::Vector3d point_m = camera.triangulate({double(p.x), double(p.y)}, d);
    const double height_m = plane.height_m(point_m);
    if (height_m < rim_m) continue;
    on_table.push_back(frame.of(point_m));
    heights_m.push_back(static_cast<float>(height_m));
    if (frame.hull.empty() || cv::pointPolygonTest(frame.hull, on_table.back(), true) > -beyond_edge_m)
      continue;
    // The table ends there only if there is something else to see: the image may end before it does.
    const Eigen::Vector3d foot_m = point_m - height_m * plane.normal;
    const Eigen::Vector2d foot_px = foot_m.z() > 0 ? camera.project(foot_m) : Eigen::Vector2d(-1, -1);
    beyond_edge += image.contains({foot_px.x(), foot_px.y()}) ? 1 : 0;
  }
  constexpr std::size_t least = 20;
  constexpr double least_share = 0.05, least_beyond = 0.1;
  const auto known = static_cast<double>(heights_m.size());
  if (heights_m.size() < least || known < least_share * static_cast<double>(pixels.size())) return;
  const cv::Size2f foot = footprint(on_table);
  object.size_m = {foot.width, foot.height, quantile(heights_m, inner_share)};
  object.leaves_table = beyond_edge > least_beyond * known;
}

}  // namespace graspctx::detail
