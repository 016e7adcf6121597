#include "graspctx/segmentation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "detail/figure_ground.hpp"
#include "detail/hypotheses.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/relief.hpp"
#include "detail/scene_checks.hpp"
#include "detail/texture.hpp"

namespace graspctx {

namespace {

using detail::Hypothesis;

/// Share of the textured pixels whose disparity both views agree on. Of two views that show different
/// scenes, or that are swapped, hardly any do.
double reliable_share(const cv::Mat& left, const Disparity& disparity) {
  constexpr double texture_sigmas = 3;  // well textured: a failure there is the pair's, not the table's
  const cv::Mat textured = detail::horizontal_texture(left, texture_sigmas);
  int known = 0, all = 0;
  for (int v = 0; v < left.rows; ++v) {
    const auto* dense = disparity.dense.ptr<float>(v);
    const auto* reliable = disparity.reliable.ptr<float>(v);
    const auto* here = textured.ptr<uchar>(v);
    // The leftmost columns may lie outside the right view.
    for (int u = left.cols / 8; u < left.cols; ++u) {
      if (!here[u]) continue;
      ++all;
      known += !std::isnan(dense[u]) && !std::isnan(reliable[u]) ? 1 : 0;
    }
  }
  return all > 0 ? static_cast<double>(known) / all : 0;
}

/// The same picture twice has no depth.
bool are_the_same_view(const cv::Mat& left, const cv::Mat& right) {
  const double difference = cv::norm(left, right, cv::NORM_L1) / static_cast<double>(left.total());
  return difference < 0.5 * detail::noise_sigma(left);
}

cv::Mat grown(const cv::Mat& mask, int by_px) {
  cv::Mat result;
  cv::dilate(mask, result, cv::Mat::ones(2 * by_px + 1, 2 * by_px + 1, CV_8U));
  return result;
}

cv::Mat shrunk(const cv::Mat& mask, int by_px) {
  cv::Mat result;
  cv::erode(mask, result, cv::Mat::ones(2 * by_px + 1, 2 * by_px + 1, CV_8U));
  return result;
}

/// The connected parts of a mask that hold enough of the seeds.
cv::Mat parts_with_seeds(const cv::Mat& mask, const cv::Mat& seeds) {
  cv::Mat labels;
  const int count = cv::connectedComponents(mask, labels, 8, CV_32S);
  std::vector<int> in_part(static_cast<std::size_t>(count), 0);
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      if (seeds.at<uchar>(v, u)) ++in_part[static_cast<std::size_t>(labels.at<int>(v, u))];
    }
  }
  in_part[0] = 0;
  const int most = *std::max_element(in_part.begin(), in_part.end());
  cv::Mat kept = cv::Mat::zeros(mask.size(), CV_8UC1);
  for (int label = 1; label < count; ++label) {
    if (in_part[static_cast<std::size_t>(label)] * 5 > most) kept.setTo(255, labels == label);
  }
  return kept;
}

/// III-A, Fig. 2a: the view is fixated on the hypothesis, so that it has zero disparity, and the figure grows
/// by continuity in depth: a watershed on the disparity between what is at zero and what is far from it.
cv::Mat figure_at_zero_disparity(const Hypothesis& hypothesis, const cv::Mat& disparity,
                                 const StereoCamera& camera) {
  const double band_px = detail::zero_disparity_band_px(hypothesis.disparity_px + camera.doffs_px);
  cv::Mat shown = cv::Mat::zeros(disparity.size(), CV_8UC3);
  cv::Mat markers = cv::Mat::zeros(disparity.size(), CV_32S);
  const cv::Rect near = cv::boundingRect(grown(hypothesis.seeds, 20));
  const cv::Mat core = shrunk(hypothesis.seeds, 2);
  constexpr int figure = 1, ground = 2;
  for (int v = 0; v < disparity.rows; ++v) {
    for (int u = 0; u < disparity.cols; ++u) {
      const float d = disparity.at<float>(v, u);
      int& marker = markers.at<int>(v, u);
      if (!near.contains({u, v})) {
        marker = ground;
        continue;
      }
      if (std::isnan(d)) continue;
      const double off = d - hypothesis.disparity_px;
      const auto level = cv::saturate_cast<uchar>(128 + 40 * off / band_px);
      shown.at<cv::Vec3b>(v, u) = {level, level, level};
      if (std::abs(off) > 1.3 * band_px) {
        marker = ground;
      } else if (std::abs(off) < band_px && core.at<uchar>(v, u)) {
        marker = figure;
      }
    }
  }
  if (cv::countNonZero(markers == figure) == 0) return {};
  cv::watershed(shown, markers);
  return parts_with_seeds(markers == figure, hypothesis.seeds);
}

/// III-A, Fig. 2b: what does not belong to the plane.
cv::Mat figure_off_plane(const Hypothesis& hypothesis) {
  cv::Mat mask;
  cv::morphologyEx(hypothesis.seeds, mask, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  return parts_with_seeds(mask, hypothesis.seeds);
}

cv::Mat convex_hull(const cv::Mat& mask) {
  std::vector<cv::Point> points, hull;
  cv::findNonZero(mask, points);
  cv::convexHull(points, hull);
  cv::Mat filled = cv::Mat::zeros(mask.size(), CV_8UC1);
  cv::fillConvexPoly(filled, hull, 255);
  return filled;
}

/// What a pixel of unknown depth says: nothing, unless the ground around the object is known nearly
/// everywhere. Then it is no ground: plain objects on textured tables show as holes in it.
double unknown_odds(const cv::Mat& ground, const cv::Mat& outside) {
  constexpr double unknown_of_figure = 0.5;
  const double all = std::max(1, cv::countNonZero(outside));
  const double unknown_of_ground = 1 - cv::countNonZero(ground & outside) / all;
  return std::clamp(std::log(unknown_of_figure / std::max(unknown_of_ground, 0.02)), -0.3, 1.5);
}

/// III-A, Fig. 2c: depth and colour together, in a region around the hypothesis.
cv::Mat figure_by_colour(const Hypothesis& hypothesis, const cv::Mat& image, const cv::Mat& known_ground,
                         const cv::Mat& others) {
  const cv::Rect box = cv::boundingRect(hypothesis.seeds);
  const int margin = std::max(12, static_cast<int>(0.2 * std::max(box.width, box.height)));
  const cv::Rect region =
      cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
      cv::Rect({0, 0}, image.size());
  detail::FigureEvidence evidence;
  evidence.image = image(region);
  const cv::Mat seeds = hypothesis.seeds(region);
  // The region is larger than the object: what runs over its sides is not the object's.
  cv::Mat sides(image.size(), CV_8UC1, cv::Scalar(255));
  sides(cv::Rect(region.x + 1, region.y + 1, region.width - 2, region.height - 2)).setTo(0);
  for (int side = 0; side < 2; ++side) {
    sides.col(side * (image.cols - 1)).setTo(0);
    sides.row(side * (image.rows - 1)).setTo(0);
  }
  const cv::Mat ground = known_ground(region) & ~seeds;
  const cv::Mat sure_figure = shrunk(seeds, 2), sure_ground = shrunk(ground, 2);
  evidence.figure_seeds = cv::countNonZero(sure_figure) > 50 ? sure_figure : seeds;
  const cv::Mat outside = ~grown(convex_hull(seeds), std::max(5, margin / 2));
  evidence.ground_seeds = sure_ground | outside;
  evidence.log_odds = cv::Mat(region.size(), CV_32FC1, cv::Scalar(unknown_odds(ground, outside)));
  evidence.log_odds.setTo(-0.3, outside);
  evidence.log_odds.setTo(-1, ground);
  evidence.log_odds.setTo(1, seeds);
  evidence.log_odds.setTo(-2, sure_ground);
  evidence.log_odds.setTo(4, sure_figure);
  evidence.log_odds.setTo(-20, (others(region) | sides(region)) & ~seeds);

  cv::Mat mask = cv::Mat::zeros(image.size(), CV_8UC1);
  detail::cut_figure(evidence).copyTo(mask(region));
  return parts_with_seeds(mask, hypothesis.seeds);
}

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

/// Of the hypotheses the one that is looked at, or a new one where they leave the pixel out.
std::vector<Hypothesis> at_fixation(std::vector<Hypothesis> hypotheses, const cv::Point& at,
                                    const cv::Mat& table, const Disparity& disparity,
                                    const StereoCamera& camera, const SegmentationOptions& options) {
  constexpr int near_px = 5;
  for (Hypothesis& hypothesis : hypotheses) {
    if (grown(hypothesis.seeds, near_px).at<uchar>(at)) return {std::move(hypothesis)};
  }
  std::vector<Hypothesis> found;
  if (!table.empty() && table.at<uchar>(at)) return found;
  if (auto hypothesis = detail::hypothesis_at(at, disparity, camera, options)) {
    found.push_back(std::move(*hypothesis));
  }
  return found;
}

}  // namespace

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
}

Segmentation segment_objects(const RectifiedPair& pair, const Disparity& disparity,
                             const StereoCamera& camera, const SegmentationOptions& options) {
  options.check();
  camera.check();
  detail::require_scene(pair, disparity);
  const cv::Size size = pair.left.size();
  if (options.fixation_px) {
    const Eigen::Vector2d& at = *options.fixation_px;
    detail::require_option(
        at.x() >= 0 && at.y() >= 0 && at.x() <= size.width - 1 && at.y() <= size.height - 1,
        "fixation_px must lie inside the image");
  }

  Segmentation result;
  result.instance_ids = cv::Mat::zeros(size, CV_8UC1);
  const cv::Mat left = detail::grey(pair.left), right = detail::grey(pair.right);
  if (are_the_same_view(left, right)) {
    result.warnings.emplace_back("the two views are the same picture: there is no depth in them");
    return result;
  }
  const double share = reliable_share(left, disparity);
  if (share < options.min_reliable_share) {
    result.warnings.push_back(
        "only " + std::to_string(static_cast<int>(100 * share)) +
        " % of the textured pixels agree between the views: not a rectified stereo pair "
        "of one scene, left view first");
    return result;
  }

  std::vector<Hypothesis> hypotheses;
  detail::Relief relief;
  cv::Mat table;
  if (options.cues != CueLevel::disparity) {
    result.table = fit_table_plane(pair, disparity, camera);
    if (!result.table) {
      result.warnings.emplace_back("no support plane: objects are told by steps in depth alone");
    }
  }
  if (result.table) {
    relief = detail::relief_over_plane(pair, disparity, *result.table);
    hypotheses = detail::hypotheses_on_table(pair, relief, *result.table, camera, options);
    table = ground_of(relief, 0.4);
  } else {
    hypotheses = detail::hypotheses_by_disparity(disparity, camera, options);
  }
  if (options.fixation_px) {
    const cv::Point at(static_cast<int>(std::lround(options.fixation_px->x())),
                       static_cast<int>(std::lround(options.fixation_px->y())));
    hypotheses = at_fixation(std::move(hypotheses), at, table, disparity, camera, options);
  }
  if (static_cast<int>(hypotheses.size()) > options.max_objects) {
    hypotheses.resize(static_cast<std::size_t>(options.max_objects));
  }

  cv::Mat all_seeds = cv::Mat::zeros(size, CV_8UC1);
  for (const Hypothesis& hypothesis : hypotheses) all_seeds |= hypothesis.seeds;
  for (const Hypothesis& hypothesis : hypotheses) {
    cv::Mat mask;
    if (options.cues == CueLevel::colour) {
      const cv::Mat ground =
          result.table ? table : ground_off_zero_disparity(hypothesis, disparity.dense, camera);
      mask = figure_by_colour(hypothesis, pair.left, ground, all_seeds & ~hypothesis.seeds);
    } else if (options.cues == CueLevel::plane && result.table) {
      mask = figure_off_plane(hypothesis);
    } else {
      mask = figure_at_zero_disparity(hypothesis, disparity.dense, camera);
    }
    if (mask.empty() || (result.table && !stands_on_table(mask, relief.residual_px))) continue;
    mask.setTo(0, result.instance_ids);  // what was looked at first keeps its pixels
    constexpr int least_px = 30;
    if (cv::countNonZero(mask) < least_px) continue;
    const int id = static_cast<int>(result.objects.size()) + 1;
    result.instance_ids.setTo(id, mask);
    result.objects.push_back(describe_object(mask, id));
    result.objects.back().saliency = hypothesis.saliency;
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
