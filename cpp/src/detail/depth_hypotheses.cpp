#include "detail/depth_hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "detail/masks.hpp"
#include "detail/quantile.hpp"

namespace graspctx::detail {

namespace {

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

  cv::Mat in_box(half, CV_8UC1, cv::Scalar(options.roi_px ? 0 : 255));
  if (options.roi_px) {
    const cv::Rect& box = *options.roi_px;
    in_box(cv::Rect(box.x / 2, box.y / 2, (box.width + 1) / 2, (box.height + 1) / 2) & cv::Rect({0, 0}, half))
        .setTo(255);
  }

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
    standing &= in_box;
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
      hypothesis.saliency = saliency_of(4 * area, fixated_px, camera);
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
  const int area = cv::countNonZero(hypothesis.seeds);
  if (area == 0) return std::nullopt;
  hypothesis.saliency = saliency_of(area, hypothesis.disparity_px, camera);
  return hypothesis;
}

}  // namespace graspctx::detail
