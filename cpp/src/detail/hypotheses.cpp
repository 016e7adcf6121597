#include "detail/hypotheses.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "detail/plane_geometry.hpp"
#include "detail/quantile.hpp"
#include "detail/texture.hpp"

namespace graspctx::detail {

namespace {

void sort_by_saliency(std::vector<Hypothesis>& hypotheses) {
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const auto& a, const auto& b) { return a.saliency > b.saliency; });
}

std::vector<cv::Point> where(const cv::Mat& mask) {
  std::vector<cv::Point> points;
  cv::findNonZero(mask, points);
  return points;
}

/// Bird's-eye view: a point of the camera frame on the table's own two axes (m).
struct TableAxes {
  Eigen::Vector3d right, nearer;

  explicit TableAxes(const TablePlane& plane) {
    right = (Eigen::Vector3d::UnitX() - plane.normal.x() * plane.normal).normalized();
    nearer = right.cross(plane.normal);
  }
  cv::Point2f of(const Eigen::Vector3d& point_m) const {
    return {static_cast<float>(right.dot(point_m)), static_cast<float>(nearer.dot(point_m))};
  }
};

/// The connected parts of a mask that hold at least `least` pixels of another.
cv::Mat parts_holding(const cv::Mat& mask, const cv::Mat& other, int least) {
  cv::Mat labels;
  const int count = cv::connectedComponents(mask, labels, 8, CV_32S);
  std::vector<int> held(static_cast<std::size_t>(count), 0);
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      if (other.at<uchar>(v, u)) ++held[static_cast<std::size_t>(labels.at<int>(v, u))];
    }
  }
  held[0] = 0;
  cv::Mat kept(mask.size(), CV_8UC1);
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      kept.at<uchar>(v, u) = held[static_cast<std::size_t>(labels.at<int>(v, u))] >= least ? 255 : 0;
    }
  }
  return kept;
}

/// The table as far as it is seen: convex hull, on its own axes, of what lies on the plane.
std::vector<cv::Point2f> table_hull(const Relief& relief, const TablePlane& plane, const StereoCamera& camera,
                                    const TableAxes& axes) {
  const cv::Size size = relief.residual_px.size();
  cv::Mat on_plane(size, CV_32FC1), off_plane(size, CV_32FC1);
  const double within_px = std::max(0.5, 2 * plane.sigma_px);
  for (int v = 0; v < size.height; ++v) {
    const auto* residual = relief.residual_px.ptr<float>(v);
    for (int u = 0; u < size.width; ++u) {
      on_plane.at<float>(v, u) = std::abs(residual[u]) < within_px ? 1.0F : 0.0F;
      off_plane.at<float>(v, u) = std::abs(residual[u]) >= within_px ? 1.0F : 0.0F;
    }
  }
  // A wall or floor that crosses the plane lies on it along a line only: look at the share in a window.
  const cv::Size window(21, 21);
  cv::boxFilter(on_plane, on_plane, CV_32F, window);
  cv::boxFilter(off_plane, off_plane, CV_32F, window);
  on_plane = (on_plane > off_plane) & (on_plane > 0.15);
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(on_plane, labels, stats, centres, 8, CV_32S);
  int largest = 0;
  for (int label = 1; label < count; ++label) {
    largest = std::max(largest, stats.at<int>(label, cv::CC_STAT_AREA));
  }
  on_plane = parts_holding(on_plane, on_plane, largest / 10);
  std::vector<cv::Point2f> points;
  for (const cv::Point& pixel : where(on_plane)) {
    if ((pixel.x + pixel.y) % 3 != 0) continue;
    const double d = plane_disparity(plane, pixel.x, pixel.y);
    if (d + camera.doffs_px <= 0) continue;
    points.push_back(axes.of(camera.triangulate({double(pixel.x), double(pixel.y)}, d)));
  }
  std::vector<cv::Point2f> hull;
  if (points.size() >= 3) cv::convexHull(points, hull);
  return hull;
}

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

cv::Mat near_zero_disparity(const cv::Mat& disparity, double fixated_px, double band_px) {
  cv::Mat mask;
  cv::inRange(disparity, fixated_px - band_px, fixated_px + band_px, mask);
  return mask;
}

/// What counts as a step in depth rather than a slope.
double step_in_depth_px(double shifted_px) {
  return std::max(1.0, 0.015 * shifted_px);
}

/// Of a mask of one depth (CV_8UC1), the runs along its rows with a step down to something farther at both
/// ends. Ground of the same depth comes along, but it is cut off by the band of depth and not by a step.
cv::Mat runs_between_steps(const cv::Mat& mask, const cv::Mat& disparity, double step_px) {
  constexpr int look_px = 12;
  cv::Mat runs = cv::Mat::zeros(mask.size(), CV_8UC1);
  for (int v = 0; v < mask.rows; ++v) {
    const auto* row = disparity.ptr<float>(v);
    // Is the next known pixel from here, just outside of the run, a step farther away?
    const auto steps_down = [&](int u, int direction) {
      const float here = row[u];
      u += 2 * direction;
      for (int i = 0; i < look_px && u >= 0 && u < mask.cols; ++i, u += direction) {
        if (!std::isnan(row[u])) return row[u] < here - step_px;
      }
      return false;
    };
    const auto* in_mask = mask.ptr<uchar>(v);
    for (int u = 0; u < mask.cols; ++u) {
      if (!in_mask[u]) continue;
      int end = u;
      while (end + 1 < mask.cols && in_mask[end + 1]) ++end;
      if (steps_down(u, -1) && steps_down(end, 1)) runs.row(v).colRange(u, end + 1).setTo(255);
      u = end;
    }
  }
  return runs;
}

}  // namespace

double zero_disparity_band_px(double shifted_px) {
  return std::max(1.5, 0.06 * shifted_px);
}

std::vector<Hypothesis> hypotheses_by_disparity(const Disparity& disparity, const StereoCamera& camera,
                                                const SegmentationOptions& options) {
  // Half size is plenty to find them.
  cv::Mat dense, reliable;
  const cv::Size half(disparity.dense.cols / 2, disparity.dense.rows / 2);
  cv::resize(disparity.dense, dense, half, 0, 0, cv::INTER_NEAREST);
  cv::resize(disparity.reliable, reliable, half, 0, 0, cv::INTER_NEAREST);
  const cv::Mat known = reliable == reliable;
  double largest = 0;
  cv::minMaxLoc(dense, nullptr, &largest, nullptr, nullptr, dense == dense);

  std::vector<Hypothesis> found;
  constexpr double depth_ratio = 1.06;  // from one fixation to the next
  constexpr double farthest_m = 5;
  const double nearest_shifted_px = largest + camera.doffs_px;
  const double farthest_shifted_px = camera.focal_px * camera.baseline_m / farthest_m;
  for (double shifted_px = nearest_shifted_px / depth_ratio; shifted_px > farthest_shifted_px;
       shifted_px /= depth_ratio) {
    const double fixated_px = shifted_px - camera.doffs_px;
    const cv::Mat at_zero = near_zero_disparity(dense, fixated_px, zero_disparity_band_px(shifted_px));
    cv::Mat standing = runs_between_steps(at_zero, dense, step_in_depth_px(shifted_px));
    cv::morphologyEx(standing, standing, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
    cv::Mat labels, stats, centres;
    const int count = cv::connectedComponentsWithStats(standing, labels, stats, centres, 8, CV_32S);
    for (int label = 1; label < count; ++label) {
      const int* stat = stats.ptr<int>(label);
      const cv::Rect box(stat[cv::CC_STAT_LEFT], stat[cv::CC_STAT_TOP], stat[cv::CC_STAT_WIDTH],
                         stat[cv::CC_STAT_HEIGHT]);
      const int area = stat[cv::CC_STAT_AREA];
      constexpr int least_area_px = 40;
      const double extent_m = 2 * std::max(box.width, box.height) * camera.baseline_m / shifted_px;
      if (area < least_area_px || extent_m < options.min_extent_m || extent_m > options.max_extent_m)
        continue;
      const cv::Mat part = labels(box) == label;
      constexpr double least_known_share = 0.4;
      if (cv::countNonZero(known(box) & part) < least_known_share * area) continue;
      Hypothesis hypothesis;
      cv::Mat seeds = cv::Mat::zeros(half, CV_8UC1);
      part.copyTo(seeds(box));
      cv::resize(seeds, hypothesis.seeds, disparity.dense.size(), 0, 0, cv::INTER_NEAREST);
      hypothesis.disparity_px = fixated_px;
      hypothesis.saliency = area;
      found.push_back(std::move(hypothesis));
    }
  }
  // Neighbouring fixations find the same object: the most salient one stays.
  sort_by_saliency(found);
  std::vector<Hypothesis> kept;
  cv::Mat taken = cv::Mat::zeros(disparity.dense.size(), CV_8UC1);
  for (Hypothesis& hypothesis : found) {
    const int area = cv::countNonZero(hypothesis.seeds);
    constexpr double most_shared = 0.3;
    if (cv::countNonZero(hypothesis.seeds & taken) > most_shared * area) continue;
    taken |= hypothesis.seeds;
    kept.push_back(std::move(hypothesis));
  }
  return kept;
}

std::optional<Hypothesis> hypothesis_at(const cv::Point& fixation, const Disparity& disparity,
                                        const StereoCamera& camera, const SegmentationOptions& options) {
  const cv::Size size = disparity.dense.size();
  const cv::Rect around = cv::Rect(fixation.x - 5, fixation.y - 5, 11, 11) & cv::Rect({0, 0}, size);
  std::vector<float> near;
  for (const cv::Mat* map : {&disparity.reliable, &disparity.dense}) {
    for (int v = around.y; near.size() < 10 && v < around.br().y; ++v) {
      for (int u = around.x; u < around.br().x; ++u) {
        if (!std::isnan(map->at<float>(v, u))) near.push_back(map->at<float>(v, u));
      }
    }
  }
  if (near.empty()) return std::nullopt;
  Hypothesis hypothesis;
  hypothesis.disparity_px = quantile(near, 0.5);
  const double shifted_px = hypothesis.disparity_px + camera.doffs_px;
  if (shifted_px <= 0) return std::nullopt;

  const auto disc = [&](double radius_m) {
    const double radius_px = std::clamp(radius_m * shifted_px / camera.baseline_m, 4.0,
                                        static_cast<double>(size.width + size.height));  // all of the image
    cv::Mat filled = cv::Mat::zeros(size, CV_8UC1);
    cv::circle(filled, fixation, static_cast<int>(radius_px), 255, cv::FILLED);
    return filled;
  };
  const cv::Mat reach = disc(options.max_extent_m / 2), gaze = disc(0.01);
  const cv::Mat at_zero =
      near_zero_disparity(disparity.dense, hypothesis.disparity_px, zero_disparity_band_px(shifted_px));
  cv::Mat standing = runs_between_steps(at_zero, disparity.dense, step_in_depth_px(shifted_px)) & reach;
  cv::morphologyEx(standing, standing, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  hypothesis.seeds = parts_holding(standing, gaze, 1) | (gaze & at_zero);
  hypothesis.saliency = cv::countNonZero(hypothesis.seeds);
  if (hypothesis.saliency <= 0) return std::nullopt;
  return hypothesis;
}

std::vector<Hypothesis> hypotheses_on_table(const RectifiedPair& pair, const Relief& relief,
                                            const TablePlane& plane, const StereoCamera& camera,
                                            const SegmentationOptions& options) {
  const TableAxes axes(plane);
  const std::vector<cv::Point2f> hull = table_hull(relief, plane, camera, axes);
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
      const cv::Point2f at = axes.of(camera.triangulate({double(u), double(v)}, d));
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
    // Size as seen, and nearness: what is large and in reach is looked at first.
    hypothesis.saliency = static_cast<double>(group.size());
    found.push_back(std::move(hypothesis));
  }
  sort_by_saliency(found);
  return found;
}

}  // namespace graspctx::detail
