#include "detail/gaze.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "detail/depth_hypotheses.hpp"
#include "detail/masks.hpp"
#include "detail/quantile.hpp"

namespace graspctx::detail {

namespace {

/// The hypotheses cut off at the box, without those that it leaves nothing of; first the one that is most of
/// what is in the box and mostly in it: a neighbour only looks in.
std::vector<Hypothesis> inside(std::vector<Hypothesis> hypotheses, const cv::Rect& box) {
  std::vector<Hypothesis> cut;
  for (Hypothesis& hypothesis : hypotheses) {
    const double all = cv::countNonZero(hypothesis.seeds);
    cv::Mat seeds = cv::Mat::zeros(hypothesis.seeds.size(), CV_8UC1);
    hypothesis.seeds(box).copyTo(seeds(box));
    const double kept = cv::countNonZero(seeds);
    if (kept <= 0) continue;
    hypothesis.seeds = seeds;
    hypothesis.saliency = kept * kept / all;
    cut.push_back(std::move(hypothesis));
  }
  sort_by_saliency(cut);
  return cut;
}

std::vector<Hypothesis> off_table(std::vector<Hypothesis> hypotheses, const cv::Mat& table) {
  if (table.empty()) return hypotheses;
  std::vector<Hypothesis> off;
  for (Hypothesis& hypothesis : hypotheses) {
    const double all = cv::countNonZero(hypothesis.seeds);
    hypothesis.seeds &= ~table;
    if (cv::countNonZero(hypothesis.seeds) > all / 2) off.push_back(std::move(hypothesis));
  }
  return off;
}

/// Of the seeds those that look like what is at the gaze: what it stands on may go on in depth, and hardly
/// ever has its colour. The others are not taken for ground, they are only not sure.
cv::Mat coloured_like_gaze(const cv::Mat& seeds, const cv::Mat& image, const cv::Mat& gaze) {
  if (image.channels() == 1 || cv::countNonZero(gaze & seeds) == 0) return seeds;
  cv::Mat lab;
  cv::cvtColor(image, lab, cv::COLOR_BGR2Lab);
  constexpr double lightness = 40, chroma = 10;  // what light and shade alone change
  constexpr double spreads = 3;
  cv::Mat alike = seeds.clone();
  for (int channel = 0; channel < 3; ++channel) {
    cv::Mat values;
    cv::extractChannel(lab, values, channel);
    std::vector<float> at_gaze, off;
    for (const cv::Point& at : where(gaze & seeds)) at_gaze.push_back(values.at<uchar>(at));
    const double middle = quantile(at_gaze, 0.5);
    for (const float value : at_gaze) off.push_back(static_cast<float>(std::abs(value - middle)));
    const double most = std::max(channel == 0 ? lightness : chroma, spreads * 1.4826 * quantile(off, 0.5));
    cv::Mat near;
    cv::inRange(values, middle - most, middle + most, near);
    alike &= near;
  }
  const cv::Mat connected = parts_holding(alike, gaze, 1);
  return cv::countNonZero(connected) > 0 ? connected : seeds;
}

}  // namespace

std::vector<Hypothesis> looked_at(std::vector<Hypothesis> hypotheses, const cv::Mat& table,
                                  const RectifiedPair& pair, const Disparity& disparity,
                                  const StereoCamera& camera, const SegmentationOptions& options) {
  if (!options.fixation_px && !options.roi_px) return hypotheses;
  const cv::Rect everywhere({0, 0}, disparity.dense.size()), box = options.roi_px.value_or(everywhere);
  if (options.roi_px) hypotheses = inside(std::move(hypotheses), box);

  std::vector<Hypothesis> found;
  if (options.fixation_px) {
    const cv::Point at(static_cast<int>(std::lround(options.fixation_px->x())),
                       static_cast<int>(std::lround(options.fixation_px->y())));
    const int near_px = std::max(1, disparity.dense.cols / 128);
    for (Hypothesis& hypothesis : hypotheses) {
      if (!grown(hypothesis.seeds, near_px).at<uchar>(at)) continue;
      found.push_back(std::move(hypothesis));
      break;
    }
    if (found.empty() && !table.empty() && table.at<uchar>(at)) return {};
    if (found.empty()) {
      auto hypothesis = hypothesis_at(at, disparity, camera, options);
      if (hypothesis) found.push_back(std::move(*hypothesis));
    }
    if (!found.empty() && table.empty() && options.cues == CueLevel::colour) {
      const cv::Mat gaze =
          disc_around(at, gaze_m, found.front().disparity_px, disparity.dense.size(), camera);
      found.front().seeds = coloured_like_gaze(found.front().seeds, pair.left, gaze);
    }
  } else if (!hypotheses.empty()) {
    found = std::move(hypotheses);
  } else if (!table.empty()) {
    found = off_table(hypotheses_by_disparity(pair, disparity, camera, options), table);
  }
  if (options.roi_px) found = inside(std::move(found), box);
  if (found.size() > 1) found.resize(1);
  return found;
}

}  // namespace graspctx::detail
