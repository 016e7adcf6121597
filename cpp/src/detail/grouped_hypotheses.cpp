#include "detail/grouped_hypotheses.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "detail/depth_hypotheses.hpp"
#include "detail/grouping.hpp"
#include "detail/grouping_trees.hpp"
#include "detail/scene_cues.hpp"
#include "detail/segment_disparity.hpp"
#include "detail/table_hypotheses.hpp"

namespace graspctx::detail {

namespace {

/// What is missed is lost, and what is found wrongly can still be seen through later: rather too much.
constexpr double least_object_probability = 0.3;

/// The pixels of a group, without the table that shows through a handle: the regions are coarse. On a plain
/// table it is what has the table's colour and is no inside by the first guess. On another, what is of a
/// common colour of the table and not seen over it, unless the object itself has this colour. CV_8UC1.
cv::Mat without_table(const cv::Mat& group, const SceneCues& cues) {
  constexpr float most_sigmas = 4.5F;
  if (cues.has_plain_table) return group & (cues.first_guess | (cues.plain_sigmas > most_sigmas));
  if (!cues.has_plane) return group;
  constexpr float raised_px = 0.3F;
  constexpr double most_alike = 0.3;
  const cv::Mat raised = group & (cues.residual_px > raised_px), like_table = cues.table_likeness > 0;
  if (cv::countNonZero(raised & like_table) > most_alike * cv::countNonZero(raised)) return group;
  return group & (raised | ~like_table);
}

}  // namespace

std::vector<Hypothesis> hypotheses_by_grouping(const RectifiedPair& pair, const Disparity& disparity,
                                               const StereoCamera& camera, const TableView& view,
                                               const SegmentationOptions& options) {
  // What stereo does not see itself is thought as far as the rest of the view.
  const cv::Mat everywhere(pair.left.size(), CV_8UC1, cv::Scalar(255));
  const double anywhere_px = median_disparity(everywhere, disparity.dense);
  const auto is_known = [&](double disparity_px) { return std::isfinite(camera.depth_m(disparity_px)); };
  if (!is_known(anywhere_px)) return {};
  std::vector<Hypothesis> found;
  cv::Mat explained = cv::Mat::zeros(pair.left.size(), CV_8UC1);
  const auto add = [&](const cv::Mat& seeds) {
    explained |= seeds;
    Hypothesis hypothesis;
    hypothesis.seeds = seeds;
    const double own_px = median_disparity(seeds, disparity.dense);
    hypothesis.disparity_px = is_known(own_px) ? own_px : anywhere_px;
    hypothesis.saliency = saliency_of(cv::countNonZero(seeds), hypothesis.disparity_px, camera);
    found.push_back(std::move(hypothesis));
  };

  const SceneCues cues = scene_cues(pair, disparity, camera, view);
  const Superpixels superpixels = find_superpixels(cues.image);
  RegionGraph graph = region_graph(cues, superpixels);
  judge_foreground(graph, cues);
  Grouping grouping(std::move(graph));
  grouping.run(learnt_union_probability, least_union_probability);
  for (const int group : grouping.groups()) {
    if (object_trees.probability(grouping.features_of(group).data()) < least_object_probability) continue;
    cv::Mat mask(superpixels.labels.size(), CV_8UC1), seeds;
    for (int v = 0; v < mask.rows; ++v) {
      for (int u = 0; u < mask.cols; ++u) {
        mask.at<uchar>(v, u) = grouping.group_of(superpixels.labels.at<int>(v, u)) == group ? 255 : 0;
      }
    }
    cv::resize(without_table(mask, cues), seeds, pair.left.size(), 0, 0, cv::INTER_NEAREST);
    add(seeds);
  }

  // Thin things are lost among the regions: what the first guess holds besides, and what stands out of the
  // plane where the trees do not see the ground for sure.
  const auto add_unexplained = [&](const cv::Mat& piece) {
    constexpr double most_explained = 0.2;
    if (cv::countNonZero(piece & explained) <= most_explained * cv::countNonZero(piece)) add(piece);
  };
  cv::Mat labels;
  const int count = cv::connectedComponents(view.first_guess, labels, 8, CV_32S);
  for (int label = 1; label < count; ++label) add_unexplained(labels == label);
  if (view.plane) {
    cv::Mat foreground(superpixels.labels.size(), CV_32FC1);
    for (int v = 0; v < foreground.rows; ++v) {
      for (int u = 0; u < foreground.cols; ++u) {
        const RegionSums& sums = grouping.region(superpixels.labels.at<int>(v, u)).sums;
        foreground.at<float>(v, u) = static_cast<float>(sums.foreground / sums.area);
      }
    }
    cv::resize(foreground, foreground, pair.left.size(), 0, 0, cv::INTER_NEAREST);
    constexpr double least_foreground = 0.1;
    for (const Hypothesis& raised :
         hypotheses_on_table(pair, view.relief, *view.plane, view.frame, camera, options)) {
      if (cv::mean(foreground, raised.seeds)[0] >= least_foreground) add_unexplained(raised.seeds);
    }
  }
  if (!view.plane) drop_parts_of_wall(pair, disparity, camera, options.max_extent_m, found);
  sort_by_saliency(found);
  return found;
}

}  // namespace graspctx::detail
