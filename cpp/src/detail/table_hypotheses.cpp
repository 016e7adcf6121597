#include "detail/table_hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "detail/masks.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/quantile.hpp"
#include "detail/texture.hpp"

namespace graspctx::detail {

namespace {

/// Pixels above the plane by more than their error. Hysteresis: what surely stands out, in pieces large
/// enough not to be noise, and what is connected to it and probably does.
cv::Mat pixels_off_plane(const Relief& relief) {
  const auto above = [&](float least_px, float least_sigmas) {
    cv::Mat mask(relief.residual_px.size(), CV_8UC1);
    for (int v = 0; v < mask.rows; ++v) {
      const auto* residual = relief.residual_px.ptr<float>(v);
      const auto* sigma = relief.sigma_px.ptr<float>(v);
      auto* to = mask.ptr<uchar>(v);
      for (int u = 0; u < mask.cols; ++u) {
        to[u] = residual[u] > std::max(least_px, least_sigmas * sigma[u]) ? 255 : 0;
      }
    }
    return mask;
  };
  constexpr int least_area_px = 25;
  const cv::Mat surely = above(0.3F, 3), probably = above(0.15F, 2);
  return parts_holding(probably, parts_holding(surely, surely, least_area_px), least_area_px);
}

/// How much better their own disparity explains the pixels than the table's: ratio of grey differences.
double explained_by_itself(const cv::Mat& left, const cv::Mat& right, const Relief& relief,
                           const TablePlane& plane, const std::vector<cv::Point>& pixels, double noise) {
  double as_table = 0, as_itself = 0;
  for (const cv::Point& p : pixels) {
    const double r = relief.residual_px.at<float>(p);
    if (std::isnan(r)) continue;
    const auto here = static_cast<double>(left.at<uchar>(p));
    const auto difference = [&](double disparity) {
      const double u = std::clamp(p.x - disparity, 0.0, right.cols - 1.001);
      const int whole = static_cast<int>(u);
      const auto* row = right.ptr<uchar>(p.y);
      return std::abs(here - (row[whole] + (u - whole) * (row[whole + 1] - row[whole])));
    };
    const double on_plane = plane_disparity(plane, p.x, p.y);
    as_table += difference(on_plane);
    as_itself += difference(on_plane + r);
  }
  const double floor = noise * static_cast<double>(pixels.size());
  return as_table / std::max(as_itself, floor);
}

}  // namespace

std::vector<Hypothesis> hypotheses_on_table(const RectifiedPair& pair, const Relief& relief,
                                            const TablePlane& plane, const TableFrame& frame,
                                            const StereoCamera& camera, const SegmentationOptions& options) {
  const std::vector<cv::Point2f>& hull = frame.hull;
  if (hull.size() < 3) return {};

  // Pixels that stand out, on the table's axes.
  constexpr double least_height_m = 0.003;
  struct Raised {
    cv::Point pixel;
    float height_m;
    cv::Point cell;
  };
  std::vector<Raised> raised;
  const auto cell = static_cast<float>(options.cell_m);
  cv::Point2f low(std::numeric_limits<float>::max(), std::numeric_limits<float>::max()), high = -low;
  for (const cv::Point2f& corner : hull) {
    low = {std::min(low.x, corner.x), std::min(low.y, corner.y)};
    high = {std::max(high.x, corner.x), std::max(high.y, corner.y)};
  }
  const float margin = 0.1F;
  low -= {margin, margin};
  high += {margin, margin};
  constexpr float largest_m = 4;  // a sliver of far table must not blow up the grid
  high = {std::min(high.x, low.x + largest_m), std::min(high.y, low.y + largest_m)};
  cv::Mat counts = cv::Mat::zeros(static_cast<int>((high.y - low.y) / cell) + 1,
                                  static_cast<int>((high.x - low.x) / cell) + 1, CV_32S);
  const cv::Mat off_plane = pixels_off_plane(relief);
  for (int v = 0; v < relief.residual_px.rows; ++v) {
    const auto* row = relief.residual_px.ptr<float>(v);
    for (int u = 0; u < relief.residual_px.cols; ++u) {
      if (!off_plane.at<uchar>(v, u)) continue;
      const double d = plane_disparity(plane, u, v) + row[u];
      if (d + camera.doffs_px <= 0) continue;
      const double height = height_m(plane, camera, u, v, d);
      if (height < least_height_m) continue;
      const cv::Point2f at = frame.of(camera.triangulate({double(u), double(v)}, d));
      if (at.x < low.x || at.y < low.y || at.x > high.x || at.y > high.y) continue;
      const cv::Point in_grid(static_cast<int>((at.x - low.x) / cell),
                              static_cast<int>((at.y - low.y) / cell));
      ++counts.at<int>(in_grid);
      raised.push_back({{u, v}, static_cast<float>(height), in_grid});
    }
  }
  cv::Mat occupied = counts >= 2;
  cv::morphologyEx(occupied, occupied, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  cv::Mat labels;
  const int count = cv::connectedComponents(occupied, labels, 8, CV_32S);

  std::vector<std::vector<Raised>> groups(static_cast<std::size_t>(count));
  for (const Raised& s : raised) groups[static_cast<std::size_t>(labels.at<int>(s.cell))].push_back(s);
  const cv::Mat left = grey(pair.left), right = grey(pair.right);
  const double noise = noise_sigma(left);
  std::vector<Hypothesis> found;
  for (int label = 1; label < count; ++label) {
    const auto& group = groups[static_cast<std::size_t>(label)];
    if (group.size() < 30) continue;
    std::vector<float> heights;
    std::vector<cv::Point2f> cells;
    std::vector<cv::Point> pixels;
    Hypothesis hypothesis;
    hypothesis.seeds = cv::Mat::zeros(left.size(), CV_8UC1);
    std::vector<float> disparities;
    for (const Raised& s : group) {
      heights.push_back(s.height_m);
      cells.emplace_back(s.cell);
      pixels.push_back(s.pixel);
      hypothesis.seeds.at<uchar>(s.pixel) = 255;
      disparities.push_back(relief.residual_px.at<float>(s.pixel) +
                            static_cast<float>(plane_disparity(plane, s.pixel.x, s.pixel.y)));
    }
    const double top_m = quantile(heights, 0.95);
    if (top_m < options.min_height_m || top_m > options.max_height_m) continue;
    const cv::RotatedRect footprint = cv::minAreaRect(cells);
    const double longest_m = (std::max(footprint.size.width, footprint.size.height) + 1) * options.cell_m;
    if (std::max(longest_m, top_m) < options.min_extent_m || longest_m > options.max_extent_m) continue;
    const cv::Point2f foot(low.x + footprint.center.x * cell, low.y + footprint.center.y * cell);
    if (cv::pointPolygonTest(hull, foot, false) < 0) continue;
    if (explained_by_itself(left, right, relief, plane, pixels, noise) < 1.2) continue;
    hypothesis.disparity_px = quantile(disparities, 0.5);
    hypothesis.saliency = saliency_of(static_cast<double>(group.size()), hypothesis.disparity_px, camera);
    found.push_back(std::move(hypothesis));
  }
  sort_by_saliency(found);
  return found;
}

}  // namespace graspctx::detail
