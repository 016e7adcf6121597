#include "detail/grouped_hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "detail/depth_hypotheses.hpp"
#include "detail/grouping.hpp"
#include "detail/scene_cues.hpp"
#include "detail/segment_disparity.hpp"
#include "detail/superpixels.hpp"
#include "detail/whole_objects.hpp"

namespace graspctx::detail {

namespace {

/// What is missed is lost, and what is found wrongly can still be seen through later: rather too much.
constexpr double least_object_probability = 0.25;

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

/// The pixels of a group, 255 in a CV_8UC1 of the size of the labels.
cv::Mat mask_of(const std::vector<int>& regions, const Superpixels& superpixels) {
  std::vector<uchar> is_part(static_cast<std::size_t>(superpixels.count), 0);
  for (const int region : regions) is_part[static_cast<std::size_t>(region)] = 255;
  cv::Mat mask(superpixels.labels.size(), CV_8UC1);
  std::transform(superpixels.labels.begin<int>(), superpixels.labels.end<int>(), mask.begin<uchar>(),
                 [&](int label) { return is_part[static_cast<std::size_t>(label)]; });
  return mask;
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

  const SceneCues cues = scene_cues(pair, disparity, camera, view);
  const Superpixels superpixels = find_superpixels(cues.image);
  RegionGraph graph = region_graph(cues, superpixels);
  judge_foreground(graph, cues);
  Grouping grouping(std::move(graph));
  grouping.run(learnt_union_probability, least_union_probability);
  std::vector<Hypothesis> found;
  for (const int group : whole_objects(grouping, learnt_probabilities(grouping), least_object_probability)) {
    const cv::Mat mask = without_table(mask_of(grouping.regions_of(group), superpixels), cues);
    Hypothesis hypothesis;
    cv::resize(mask, hypothesis.seeds, pair.left.size(), 0, 0, cv::INTER_NEAREST);
    const double own_px = median_disparity(hypothesis.seeds, disparity.dense);
    hypothesis.disparity_px = is_known(own_px) ? own_px : anywhere_px;
    hypothesis.saliency = saliency_of(cv::countNonZero(hypothesis.seeds), hypothesis.disparity_px, camera);
    found.push_back(std::move(hypothesis));
  }
  if (!view.plane) drop_parts_of_wall(pair, disparity, camera, options.max_extent_m, found);
  sort_by_saliency(found);
  return found;
}

}  // namespace graspctx::detail
