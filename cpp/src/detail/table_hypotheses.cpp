#include "detail/table_hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "detail/background_planes.hpp"
#include "detail/masks.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/quantile.hpp"
#include "detail/raised_objects.hpp"

namespace graspctx::detail {

namespace {

constexpr float on_table_px = 0.3F;  // of residual

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

/// How surely their own disparity explains the pixels better than the table's: gain in squared difference
/// between the views, in units of its noise, times the root of the number of pixels. A low object gains
/// little at each pixel, a wrong match at few.
double evidence_for_relief(const Relief& relief, const TablePlane& plane,
                           const std::vector<cv::Point>& pixels) {
  const int channels = relief.left.channels();
  const auto difference = [&](const cv::Point& p, double disparity) {
    const double u = std::clamp(p.x - disparity, 0.0, relief.right.cols - 1.001);
    const int whole = static_cast<int>(u);
    const auto part = static_cast<float>(u - whole);
    const float* here = relief.left.ptr<float>(p.y) + p.x * channels;
    const float* there = relief.right.ptr<float>(p.y) + whole * channels;
    double sum = 0;
    for (int c = 0; c < channels; ++c) {
      const float d = here[c] - (there[c] + part * (there[c + channels] - there[c]));
      sum += d * d;
    }
    return sum;
  };
  double gain = 0;
  for (const cv::Point& p : pixels) {
    const double on_plane = plane_disparity(plane, p.x, p.y);
    gain += difference(p, on_plane) - difference(p, on_plane + relief.residual_px.at<float>(p));
  }
  const double noise = 2 * relief.noise * relief.noise * channels;
  return gain / noise / std::sqrt(static_cast<double>(pixels.size()));
}

/// What lies within a convex hull on the table, or beyond it by no more than a margin.
class HullMask {
 public:
  HullMask(const std::vector<cv::Point2f>& hull, double margin_m) {
    cv::Point2f low = hull.front(), high = low;
    for (const cv::Point2f& corner : hull) {
      low = {std::min(low.x, corner.x), std::min(low.y, corner.y)};
      high = {std::max(high.x, corner.x), std::max(high.y, corner.y)};
    }
    constexpr float largest_m = 4;  // a sliver of far table must not blow up the grid
    const auto margin = static_cast<float>(margin_m);
    low_ = low - cv::Point2f(margin, margin);
    mask_ = cv::Mat::zeros(static_cast<int>((std::min(high.y - low.y, largest_m) + 2 * margin) / cell_m_) + 1,
                           static_cast<int>((std::min(high.x - low.x, largest_m) + 2 * margin) / cell_m_) + 1,
                           CV_8UC1);
    std::vector<cv::Point> corners;
    for (const cv::Point2f& corner : hull) corners.push_back(cell_of(corner));
    cv::fillConvexPoly(mask_, corners, 255);
    mask_ = grown(mask_, static_cast<int>(margin / cell_m_));
  }
  bool holds(const cv::Point2f& at) const {
    const cv::Point cell = cell_of(at);
    return cv::Rect({0, 0}, mask_.size()).contains(cell) && mask_.at<uchar>(cell);
  }

 private:
  cv::Point cell_of(const cv::Point2f& at) const {
    return {cvFloor((at.x - low_.x) / cell_m_), cvFloor((at.y - low_.y) / cell_m_)};
  }
  float cell_m_ = 0.01F;
  cv::Point2f low_;
  cv::Mat mask_;
};

/// Is it steep, with nothing of the table behind it?
bool bounds_table(const TablePlane& wall, const TablePlane& table, const TableFrame& frame) {
  constexpr double steepest_cosine = 0.5, behind_m = 0.03;
  if (std::abs(wall.normal.dot(table.normal)) > steepest_cosine) return false;
  return std::all_of(frame.hull.begin(), frame.hull.end(), [&](const cv::Point2f& at) {
    const Eigen::Vector3d corner =
        double(at.x) * frame.right + double(at.y) * frame.nearer - table.offset_m * table.normal;
    return wall.normal.dot(corner) + wall.offset_m > -behind_m;
  });
}

/// Planes through what is above the table's plane that are longer than objects are and bound the table.
std::vector<BackgroundPlane> walls_behind(const cv::Mat& disparity_px, const TablePlane& table,
                                          const TableFrame& frame, const StereoCamera& camera,
                                          double max_extent_m) {
  constexpr double least_share = 0.1, within_px = 0.75;
  constexpr int most = 4;
  std::vector<BackgroundPlane> walls;
  for (const BackgroundPlane& found : background_planes(disparity_px, least_share, most)) {
    if (!bounds_table(plane_from_disparity(found.coefficients, camera), table, frame)) continue;
    std::vector<cv::Point2f> feet;
    for (int v = 0; v < disparity_px.rows; v += 2) {
      for (int u = 0; u < disparity_px.cols; u += 2) {
        const float d = disparity_px.at<float>(v, u);
        if (std::abs(found.disparity_px(u, v) - d) < within_px) {  // false for NaN
          feet.push_back(frame.of(camera.triangulate({double(u), double(v)}, d)));
        }
      }
    }
    if (feet.empty()) continue;
    const cv::RotatedRect footprint = cv::minAreaRect(feet);
    if (std::max(footprint.size.width, footprint.size.height) > max_extent_m) walls.push_back(found);
  }
  return walls;
}

/// Does a figure lie on a wall, rather than stand before it?
bool is_part_of(const std::vector<BackgroundPlane>& walls, const std::vector<cv::Point>& pixels,
                const std::vector<float>& disparities) {
  constexpr double within_px = 1, mostly = 0.7;
  return std::any_of(walls.begin(), walls.end(), [&](const BackgroundPlane& wall) {
    int on_it = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      on_it += std::abs(wall.disparity_px(pixels[i].x, pixels[i].y) - disparities[i]) < within_px ? 1 : 0;
    }
    return on_it > mostly * static_cast<double>(pixels.size());
  });
}

}  // namespace

std::vector<Hypothesis> hypotheses_on_table(const RectifiedPair& pair, const Relief& relief,
                                            const TablePlane& plane, const TableFrame& frame,
                                            const StereoCamera& camera, const SegmentationOptions& options) {
  const std::vector<cv::Point2f>& hull = frame.hull;
  if (hull.size() < 3) return {};

  // Pixels that stand out of the table, right over it.
  constexpr double least_height_m = 0.003, margin_m = 0.05;
  const HullMask near_table(hull, margin_m);
  cv::Mat raised = pixels_off_plane(relief), ground(raised.size(), CV_8UC1);
  struct Raised {
    cv::Point pixel;
    float height_m, disparity_px;
    cv::Point2f on_table_m;
  };
  std::vector<Raised> points;
  cv::Mat disparities_off(raised.size(), CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  cv::Mat points_m(raised.size(), CV_32FC3);
  for (int v = 0; v < raised.rows; ++v) {
    const auto* residual = relief.residual_px.ptr<float>(v);
    for (int u = 0; u < raised.cols; ++u) {
      ground.at<uchar>(v, u) = residual[u] < on_table_px ? 255 : 0;
      if (!raised.at<uchar>(v, u)) continue;
      const double d = plane_disparity(plane, u, v) + residual[u];
      const double height = d + camera.doffs_px > 0 ? height_m(plane, camera, u, v, d) : 0;
      if (height >= least_height_m) disparities_off.at<float>(v, u) = static_cast<float>(d);
      const cv::Point2f at = frame.of(camera.triangulate({double(u), double(v)}, d));
      if (height < least_height_m || !near_table.holds(at)) {
        raised.at<uchar>(v, u) = 0;
      } else {
        points_m.at<cv::Point3f>(v, u) = {at.x, at.y, static_cast<float>(height)};
        points.push_back({{u, v}, static_cast<float>(height), static_cast<float>(d), at});
      }
    }
  }
  int count = 0;
  const cv::Mat labels =
      raised_objects(pair.left, raised, shrunk(ground, 1), relief.residual_px, points_m, options, count);
  std::vector<std::vector<Raised>> groups(static_cast<std::size_t>(count) + 1);
  for (const Raised& point : points) {
    groups[static_cast<std::size_t>(labels.at<int>(point.pixel))].push_back(point);
  }
  const std::vector<BackgroundPlane> walls =
      walls_behind(disparities_off, plane, frame, camera, options.max_extent_m);
  std::vector<Hypothesis> found;
  constexpr std::size_t least_px = 40;
  constexpr double least_over_table = 0.5, least_evidence = 40;
  for (int label = 1; label <= count; ++label) {
    const auto& group = groups[static_cast<std::size_t>(label)];
    if (group.size() < least_px) continue;
    std::vector<float> heights;
    std::vector<cv::Point2f> on_table;
    std::vector<cv::Point> pixels;
    Hypothesis hypothesis;
    hypothesis.seeds = cv::Mat::zeros(raised.size(), CV_8UC1);
    std::vector<float> disparities;
    for (const Raised& s : group) {
      heights.push_back(s.height_m);
      on_table.push_back(s.on_table_m);
      pixels.push_back(s.pixel);
      hypothesis.seeds.at<uchar>(s.pixel) = 255;
      disparities.push_back(s.disparity_px);
    }
    const double top_m = quantile(heights, 0.95);
    if (top_m < options.min_height_m || top_m > options.max_height_m) continue;
    const cv::RotatedRect footprint = cv::minAreaRect(on_table);
    const double longest_m = std::max(footprint.size.width, footprint.size.height);
    if (std::max(longest_m, top_m) < options.min_extent_m || longest_m > options.max_extent_m) continue;
    const auto over_table = std::count_if(on_table.begin(), on_table.end(), [&](const cv::Point2f& at) {
      return cv::pointPolygonTest(hull, at, false) >= 0;
    });
    if (over_table < least_over_table * static_cast<double>(on_table.size())) continue;
    if (is_part_of(walls, pixels, disparities)) continue;
    if (evidence_for_relief(relief, plane, pixels) < least_evidence) continue;
    hypothesis.disparity_px = quantile(disparities, 0.5);
    hypothesis.saliency = saliency_of(static_cast<double>(group.size()), hypothesis.disparity_px, camera);
    found.push_back(std::move(hypothesis));
  }
  sort_by_saliency(found);
  return found;
}

}  // namespace graspctx::detail
