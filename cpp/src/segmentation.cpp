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
#include "detail/heights.hpp"
#include "detail/masks.hpp"
#include "detail/object_measures.hpp"
#include "detail/pair_checks.hpp"
#include "detail/plain_table_objects.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/relief.hpp"
#include "detail/scene_checks.hpp"
#include "detail/segment_disparity.hpp"
#include "detail/strange_colours.hpp"
#include "detail/table_evidence.hpp"
#include "detail/table_fit.hpp"
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

/// Known pixels that lie on the table or below.
cv::Mat ground_of(const detail::Relief& relief, double least_px) {
  cv::Mat ground(relief.residual_px.size(), CV_8UC1);
  for (int v = 0; v < ground.rows; ++v) {
    for (int u = 0; u < ground.cols; ++u) {
      const float r = relief.residual_px.at<float>(v, u);
      ground.at<uchar>(v, u) = r < least_px ? 255 : 0;
    }
  }
  return ground;
}

/// On a plain table colour sees the objects whole, and depth tells those that touch. What lies elsewhere only
/// depth knows of, and only where the table goes on.
std::vector<Hypothesis> with_plain_table(const std::vector<Hypothesis>& by_colour,
                                         std::vector<Hypothesis> by_depth, const detail::PlainTable& table,
                                         const std::vector<detail::Footprint>& footprints,
                                         const cv::Mat& image, const StereoCamera& camera, bool goes_on) {
  std::vector<Hypothesis> all;
  cv::Mat seen = grown(table.extent, 4);
  for (const Hypothesis& hypothesis : by_colour) {
    seen |= hypothesis.figure;
    for (Hypothesis& part : detail::split_by_depth(hypothesis, by_depth, footprints, image, camera)) {
      all.push_back(std::move(part));
    }
  }
  if (!goes_on) by_depth.clear();
  for (Hypothesis& hypothesis : by_depth) {
    if (2 * cv::countNonZero(hypothesis.seeds & seen) > cv::countNonZero(hypothesis.seeds)) continue;
    all.push_back(std::move(hypothesis));
  }
  detail::sort_by_saliency(all);
  return all;
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

  std::vector<Hypothesis> hypotheses;
  detail::Relief relief;
  detail::TableFrame frame;
  cv::Mat table;
  std::optional<detail::PlainTable> plain;
  if (options.cues != CueLevel::disparity) {
    plain = detail::find_plain_table(pair.left);
    result.table = detail::fit_table_plane(pair, disparity, camera, options, plain);
  }
  if (options.cues != CueLevel::colour) plain.reset();  // what lies on it is told by colour
  if (result.table) relief = detail::relief_over_plane(pair, disparity, *result.table);
  const bool plain_on_plane = plain && result.table && detail::lies_on_plane(*plain, relief);
  if (plain && result.table && !plain_on_plane) {
    if (!detail::outweighs_plane(*plain, relief)) {
      plain.reset();
    } else if (!options.table) {
      result.table.reset();
    }
  }
  if (options.cues != CueLevel::disparity && !result.table) {
    result.warnings.emplace_back(plain ? "no support plane: objects are told by colour on a plain table"
                                       : "no support plane: objects are told by steps in depth alone");
  }
  if (result.table) {
    frame = detail::table_frame(relief, *result.table, camera);
    std::vector<cv::Mat> low;
    if (options.cues == CueLevel::colour) {
      low = detail::raise_strange_colours(pair, *result.table, frame, camera, relief);
    }
    result.heights_m = detail::heights_over_plane(relief.residual_px, *result.table, camera);
    hypotheses = detail::hypotheses_on_table(pair, relief, *result.table, frame, camera, options);
    detail::add_low_objects(low, *result.table, frame, relief, camera, options, hypotheses);
    table = ground_of(relief, 0.4);
  } else {
    hypotheses = detail::hypotheses_by_disparity(pair, disparity, camera, options);
  }
  if (plain) {
    if (result.table && !plain_on_plane) hypotheses.clear();  // of another plane than the table's
    std::vector<detail::Footprint> footprints;
    for (const Hypothesis& hypothesis : hypotheses) {
      if (!plain_on_plane) break;
      footprints.push_back(detail::footprint_of(hypothesis.seeds, relief, *result.table, frame, camera));
    }
    const auto by_colour = detail::hypotheses_on_plain_table(
        pair, disparity, *plain, plain_on_plane ? &relief : nullptr, camera, options);
    hypotheses = with_plain_table(by_colour, std::move(hypotheses), *plain, footprints, pair.left, camera,
                                  plain_on_plane && detail::goes_on_textured(*plain, relief));
    if (!result.table) {
      detail::drop_parts_of_wall(pair, disparity, camera, options.max_extent_m, hypotheses);
    }
    table = table.empty() ? plain->region : table | plain->region;
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
  if (result.table && options.cues == CueLevel::colour) {
    table_odds = detail::odds_of_table(relief, *result.table, all_seeds);
  }
  for (const Hypothesis& hypothesis : hypotheses) {
    cv::Mat mask = hypothesis.figure.clone();
    if (mask.empty()) {
      if (options.cues == CueLevel::colour) {
        const cv::Mat ground =
            result.table ? table : ground_off_zero_disparity(hypothesis, disparity.dense, camera);
        mask = detail::figure_by_colour(hypothesis, pair.left, ground,
                                        (all_seeds & ~hypothesis.seeds) | out_of_box, table_odds);
      } else if (options.cues == CueLevel::plane && result.table) {
        mask = detail::figure_off_plane(hypothesis, table, all_seeds & ~hypothesis.seeds);
      } else {
        mask = detail::figure_at_zero_disparity(hypothesis, disparity.dense, camera);
      }
      if (mask.empty() || (result.table && !stands_on_table(mask, relief.residual_px))) continue;
    }
    mask.setTo(0, out_of_box);
    mask.setTo(0, result.instance_ids);  // what was looked at first keeps its pixels
    constexpr int least_px = 30;
    if (cv::countNonZero(mask) < least_px) continue;
    const int id = static_cast<int>(result.objects.size()) + 1;
    result.instance_ids.setTo(id, mask);
    result.objects.push_back(describe_object(mask, id));
    result.objects.back().saliency = hypothesis.saliency;
    result.objects.back().depth_m = median_depth_m(mask, disparity, camera);
    if (result.table) {
      detail::measure_on_table(result.objects.back(), mask, disparity, relief, *result.table, frame, camera);
    }
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
