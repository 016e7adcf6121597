#include "graspctx/segmentation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "detail/check.hpp"
#include "detail/depth_hypotheses.hpp"
#include "detail/figure.hpp"
#include "detail/gaze.hpp"
#include "detail/grouped_hypotheses.hpp"
#include "detail/heights.hpp"
#include "detail/masks.hpp"
#include "detail/object_measures.hpp"
#include "detail/pair_checks.hpp"
#include "detail/plain_table_objects.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/relief.hpp"
#include "detail/scene_checks.hpp"
#include "detail/segment_disparity.hpp"
#include "detail/table_evidence.hpp"
#include "detail/table_hypotheses.hpp"

namespace graspctx {

namespace {

using detail::grown;
using detail::Hypothesis;

/// Does the lower half of a figure border on the table, and not rather on something below it? A piece of
/// floor that was matched wrongly seems to hover over the table.
bool stands_on_table(const cv::Mat& mask, const cv::Mat& residual_px) {
  const cv::Rect box = cv::boundingRect(mask);
  const cv::Mat ring = grown(mask, 8) & ~grown(mask, 2);
  int on_table = 0, below = 0;
  for (int v = box.y + box.height / 2; v < std::min(box.br().y + 8, mask.rows); ++v) {
    for (int u = std::max(box.x - 8, 0); u < std::min(box.br().x + 8, mask.cols); ++u) {
      if (!ring.at<uchar>(v, u)) continue;
      const float r = residual_px.at<float>(v, u);
      on_table += std::abs(r) < 0.5F ? 1 : 0;
      below += r < -1 ? 1 : 0;
    }
  }
  return on_table >= below;
}

std::string describe(const cv::Rect& box) {
  return "x " + std::to_string(box.x) + ", y " + std::to_string(box.y) + ", " + std::to_string(box.width) +
         "x" + std::to_string(box.height);
}

ObjectHypothesis describe_object(const cv::Mat& mask, int id) {
  ObjectHypothesis object;
  object.id = id;
  object.bounding_box_px = cv::boundingRect(mask);
  const cv::Moments moments = cv::moments(mask, true);
  object.centroid_px = {moments.m10 / moments.m00, moments.m01 / moments.m00};
  const cv::Rect& box = object.bounding_box_px;
  object.touches_border = box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows;
  return object;
}

std::optional<double> median_depth_m(const cv::Mat& mask, const Disparity& disparity,
                                     const StereoCamera& camera) {
  for (const cv::Mat* map : {&disparity.reliable, &disparity.dense}) {
    const double depth_m = camera.depth_m(detail::median_disparity(mask, *map));
    if (std::isfinite(depth_m)) return depth_m;
  }
  return std::nullopt;
}

/// Do its measures, where they are known, keep to the limits, as far as they can be trusted?
bool has_size_of_object(const ObjectHypothesis& object, const StereoCamera& camera,
                        const SegmentationOptions& options) {
  if (!object.size_m || !object.depth_m) return true;
  constexpr double unsure_px = 0.5, unsure_share = 1.25;
  const double height_m = object.size_m->z(), length_m = object.size_m->x();
  const double give_m = unsure_px * *object.depth_m * *object.depth_m / (camera.focal_px * camera.baseline_m);
  return height_m >= options.min_height_m - give_m && height_m <= options.max_height_m + give_m &&
         std::max(length_m, height_m) >= options.min_extent_m &&
         length_m <= unsure_share * options.max_extent_m;
}

/// Known pixels far from the depth of the hypothesis: the ground where there is no table.
cv::Mat ground_off_zero_disparity(const Hypothesis& hypothesis, const cv::Mat& disparity,
                                  const StereoCamera& camera) {
  const double band_px = detail::zero_disparity_band_px(hypothesis.disparity_px + camera.doffs_px);
  cv::Mat ground(disparity.size(), CV_8UC1);
  for (int v = 0; v < ground.rows; ++v) {
    for (int u = 0; u < ground.cols; ++u) {
      ground.at<uchar>(v, u) =
          std::abs(disparity.at<float>(v, u) - hypothesis.disparity_px) > 1.3 * band_px ? 255 : 0;
    }
  }
  return ground;
}

/// The part of the options that depends on the image.
void require_inside(const SegmentationOptions& options, const cv::Size& size) {
  using detail::require_option;
  const std::string image = "the image of " + std::to_string(size.width) + "x" + std::to_string(size.height);
  if (options.fixation_px) {
    const Eigen::Vector2d& at = *options.fixation_px;
    require_option(at.x() >= 0 && at.y() >= 0 && at.x() <= size.width - 1 && at.y() <= size.height - 1,
                   "fixation_px must lie inside " + image + " px, got " + std::to_string(at.x()) + ", " +
                       std::to_string(at.y()));
  }
  if (options.roi_px) {
    const cv::Rect& box = *options.roi_px;
    require_option(box.x <= size.width - box.width && box.y <= size.height - box.height,
                   "roi_px must lie inside " + image + " px, got " + describe(box));
  }
}

}  // namespace

const char* name_of(CueLevel level) {
  switch (level) {
    case CueLevel::disparity:
      return "disparity";
    case CueLevel::plane:
      return "plane";
    case CueLevel::colour:
      break;
  }
  return "colour";
}

void SegmentationOptions::check() const {
  using detail::require_option;
  require_option(cues == CueLevel::disparity || cues == CueLevel::plane || cues == CueLevel::colour,
                 "cues must be disparity, plane or colour");
  require_option(max_objects >= 1 && max_objects <= 255,
                 "max_objects must be between 1 and 255, got " + std::to_string(max_objects));
  require_option(min_height_m >= 0 && min_height_m < max_height_m && std::isfinite(max_height_m),
                 "expected 0 <= min_height_m < max_height_m, got " + std::to_string(min_height_m) + " and " +
                     std::to_string(max_height_m));
  require_option(min_extent_m >= 0 && min_extent_m < max_extent_m && std::isfinite(max_extent_m),
                 "expected 0 <= min_extent_m < max_extent_m, got " + std::to_string(min_extent_m) + " and " +
                     std::to_string(max_extent_m));
  require_option(min_reliable_share >= 0 && min_reliable_share <= 1,
                 "min_reliable_share must be between 0 and 1, got " + std::to_string(min_reliable_share));
  require_option(cell_m >= 0.001 && cell_m <= 0.1,
                 "cell_m must be between 0.001 and 0.1, got " + std::to_string(cell_m));
  require_option(!fixation_px || fixation_px->allFinite(), "fixation_px must be finite");
  require_option(!roi_px || (roi_px->x >= 0 && roi_px->y >= 0 && roi_px->width >= 1 && roi_px->height >= 1),
                 "roi_px must hold at least one pixel and start inside the image, got " +
                     (roi_px ? describe(*roi_px) : ""));
  if (roi_px && fixation_px) {
    const cv::Rect2d box(*roi_px);
    require_option(fixation_px->x() >= box.x && fixation_px->y() >= box.y &&
                       fixation_px->x() <= box.br().x - 1 && fixation_px->y() <= box.br().y - 1,
                   "fixation_px must lie inside roi_px, " + describe(*roi_px));
  }
  constexpr double unit_within = 1e-3;
  require_option(!table || (table->normal.allFinite() && std::abs(table->normal.norm() - 1) <= unit_within),
                 "table: the normal must have length 1");
  require_option(!table || (table->offset_m > 0 && std::isfinite(table->offset_m)),
                 "table: the normal must point towards the camera, and offset_m be a number > 0");
  require_option(!gravity || (gravity->allFinite() && gravity->norm() > 1e-6 && gravity->norm() < 1e6),
                 "gravity must be finite and not zero");
}

Segmentation segment_objects(const RectifiedPair& pair, const Disparity& disparity,
                             const StereoCamera& camera, const SegmentationOptions& options) {
  options.check();
  camera.check();
  detail::require_scene(pair, disparity);
  const cv::Size size = pair.left.size();
  require_inside(options, size);

  Segmentation result;
  result.instance_ids = cv::Mat::zeros(size, CV_8UC1);
  const detail::PairChecks checks = detail::check_pair(pair, disparity, options.min_reliable_share);
  result.warnings = checks.warnings;
  result.vertical_offset_px = checks.vertical_offset_px;
  if (checks.refusal) {
    result.warnings.push_back(*checks.refusal);
    return result;
  }

  const detail::TableView view = detail::look_at_table(pair, disparity, camera, options);
  result.table = view.plane;
  const detail::Relief& relief = view.relief;
  const detail::TableFrame& frame = view.frame;
  const cv::Mat table = view.ground();
  if (options.cues != CueLevel::disparity && !view.plane) {
    result.warnings.emplace_back(view.plain ? "no support plane: objects are told by colour on a plain table"
                                            : "no support plane: objects are told by steps in depth alone");
  }
  if (view.plane) result.heights_m = detail::heights_over_plane(relief.residual_px, *view.plane, camera);
  std::vector<Hypothesis> hypotheses;
  if (options.cues == CueLevel::colour && (view.plane || view.plain)) {
    hypotheses = detail::hypotheses_by_grouping(pair, disparity, camera, view, options);
  } else if (view.plane) {
    hypotheses = view.raised;
  } else {
    hypotheses = detail::hypotheses_by_disparity(pair, disparity, camera, options);
  }
  hypotheses = detail::looked_at(std::move(hypotheses), table, pair, disparity, camera, options);
  if (static_cast<int>(hypotheses.size()) > options.max_objects) {
    hypotheses.resize(static_cast<std::size_t>(options.max_objects));
  }

  cv::Mat out_of_box = cv::Mat::zeros(size, CV_8UC1);
  if (options.roi_px) {
    out_of_box.setTo(255);
    out_of_box(*options.roi_px).setTo(0);
  }
  cv::Mat all_seeds = cv::Mat::zeros(size, CV_8UC1);
  for (const Hypothesis& hypothesis : hypotheses) all_seeds |= hypothesis.seeds;
  cv::Mat table_odds;
  if (view.plane && options.cues == CueLevel::colour) {
    table_odds = detail::odds_of_table(relief, *view.plane, all_seeds);
  }
  for (const Hypothesis& hypothesis : hypotheses) {
    // Each is fixated in turn, and grows to a figure by the cues of the level.
    const cv::Mat others = all_seeds & ~hypothesis.seeds;
    cv::Mat mask;
    if (options.cues == CueLevel::colour) {
      const cv::Mat ground =
          table.empty() ? ground_off_zero_disparity(hypothesis, disparity.dense, camera) : table;
      mask = detail::figure_by_colour(hypothesis, pair.left, ground, others | out_of_box, table_odds);
    } else if (view.plane) {
      mask = detail::figure_off_plane(hypothesis, table, others);
    } else {
      mask = detail::figure_at_zero_disparity(hypothesis, disparity.dense, camera);
    }
    if (mask.empty() || (view.plane && !stands_on_table(mask, relief.residual_px))) continue;
    mask.setTo(0, out_of_box);
    mask.setTo(0, result.instance_ids);  // what was looked at first keeps its pixels
    constexpr int least_px = 30;
    if (cv::countNonZero(mask) < least_px) continue;
    ObjectHypothesis object = describe_object(mask, static_cast<int>(result.objects.size()) + 1);
    object.saliency = hypothesis.saliency;
    object.depth_m = median_depth_m(mask, disparity, camera);
    if (view.plane) detail::measure_on_table(object, mask, disparity, relief, *view.plane, frame, camera);
    if (!has_size_of_object(object, camera, options)) continue;
    result.instance_ids.setTo(object.id, mask);
    result.objects.push_back(std::move(object));
  }
  return result;
}

Segmentation segmentation_from_mask(const cv::Mat& instance_ids, const cv::Size& image_size) {
  detail::require_mask(instance_ids, image_size, "instance mask");
  Segmentation result;
  result.instance_ids = instance_ids.clone();
  std::array<int, 256> areas{};
  for (int v = 0; v < instance_ids.rows; ++v) {
    for (int u = 0; u < instance_ids.cols; ++u) ++areas[instance_ids.at<uchar>(v, u)];
  }
  for (int id = 1; id < 256; ++id) {
    const int area = areas[static_cast<std::size_t>(id)];
    if (area == 0) continue;
    result.objects.push_back(describe_object(instance_ids == id, id));
    result.objects.back().saliency = area;
  }
  std::stable_sort(result.objects.begin(), result.objects.end(),
                   [](const auto& a, const auto& b) { return a.saliency > b.saliency; });
  return result;
}

}  // namespace graspctx
