#include "detail/gaze.hpp"

#include <cmath>
#include <utility>

#include "detail/depth_hypotheses.hpp"
#include "detail/masks.hpp"

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
    constexpr int near_px = 5;
    for (Hypothesis& hypothesis : hypotheses) {
      if (grown(hypothesis.seeds, near_px).at<uchar>(at)) return {std::move(hypothesis)};
    }
    if (!table.empty() && table.at<uchar>(at)) return {};
    if (auto hypothesis = hypothesis_at(at, disparity, camera, options)) {
      found.push_back(std::move(*hypothesis));
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
