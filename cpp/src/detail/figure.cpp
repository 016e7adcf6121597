#include "detail/figure.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detail/depth_hypotheses.hpp"
#include "detail/figure_ground.hpp"
#include "detail/masks.hpp"
#include "detail/quantile.hpp"

namespace graspctx::detail {

namespace {

/// What a pixel of unknown depth says: nothing, unless the ground around the object is known nearly
/// everywhere. Then it is no ground: plain objects on textured tables show as holes in it.
double unknown_odds(const cv::Mat& ground, const cv::Mat& outside) {
  constexpr double unknown_of_figure = 0.5;
  const double all = std::max(1, cv::countNonZero(outside));
  const double unknown_of_ground = 1 - cv::countNonZero(ground & outside) / all;
  return std::clamp(std::log(unknown_of_figure / std::max(unknown_of_ground, 0.02)), -0.3, 1.5);
}

}  // namespace

cv::Mat figure_at_zero_disparity(const Hypothesis& hypothesis, const cv::Mat& disparity,
                                 const StereoCamera& camera) {
  const cv::Mat known = without_hidden_strips(disparity);
  std::vector<float> own;
  for (const cv::Point& at : where(hypothesis.seeds)) {
    if (!std::isnan(known.at<float>(at))) own.push_back(known.at<float>(at));
  }
  if (own.empty()) return {};
  constexpr double outliers = 0.02, beyond = 0.5;
  const double farthest_px = quantile(own, outliers), nearest_px = quantile(own, 1 - outliers);
  const double margin_px = beyond * zero_disparity_band_px(hypothesis.disparity_px + camera.doffs_px);

  // What stands on something lacks its foot: it has the depth of the ground there.
  constexpr double aside = 0.05, down = 0.15;
  const cv::Rect box = cv::boundingRect(hypothesis.seeds);
  const int to_side = 2 + static_cast<int>(aside * std::min(box.width, box.height));
  const int below = 2 + static_cast<int>(down * box.height);
  const cv::Rect reach =
      cv::Rect(box.x - to_side, box.y - to_side, box.width + 2 * to_side, box.height + to_side + below) &
      cv::Rect({0, 0}, disparity.size());

  cv::Mat shown = cv::Mat::zeros(disparity.size(), CV_8UC3);
  constexpr int figure = 1, ground = 2;
  cv::Mat markers(disparity.size(), CV_32S, cv::Scalar(ground));
  const cv::Mat core = shrunk(hypothesis.seeds, 1);
  const double range_px = nearest_px - farthest_px + 2 * margin_px;
  for (int v = reach.y; v < reach.br().y; ++v) {
    for (int u = reach.x; u < reach.br().x; ++u) {
      const float d = known.at<float>(v, u);
      const bool off = d < farthest_px - margin_px || d > nearest_px + margin_px;
      markers.at<int>(v, u) = off ? ground : core.at<uchar>(v, u) ? figure : 0;
      if (std::isnan(d)) continue;
      const auto level = cv::saturate_cast<uchar>(255 * (d - farthest_px + margin_px) / range_px);
      shown.at<cv::Vec3b>(v, u) = {level, level, level};
    }
  }
  if (cv::countNonZero(markers == figure) == 0) return {};
  cv::watershed(shown, markers);
  return parts_with_seeds(markers == figure, hypothesis.seeds);
}

cv::Mat figure_off_plane(const Hypothesis& hypothesis, const cv::Mat& known_ground, const cv::Mat& others) {
  cv::Mat mask;
  cv::morphologyEx(hypothesis.seeds, mask, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  const cv::Rect box = cv::boundingRect(hypothesis.seeds);
  const cv::Mat seeds = hypothesis.seeds(box);
  const cv::Mat ground = (known_ground(box) | others(box)) & ~seeds;
  cv::Mat inside = convex_hull(seeds) & ~ground;
  if (cv::countNonZero(ground) > 0) {
    cv::Mat to_seeds, to_ground;
    cv::distanceTransform(~seeds, to_seeds, cv::DIST_L2, cv::DIST_MASK_5);
    cv::distanceTransform(~ground, to_ground, cv::DIST_L2, cv::DIST_MASK_5);
    inside &= to_seeds < to_ground;
  }
  mask(box) |= inside;
  return parts_with_seeds(mask, hypothesis.seeds);
}

cv::Mat figure_by_colour(const Hypothesis& hypothesis, const cv::Mat& image, const cv::Mat& known_ground,
                         const cv::Mat& others, const cv::Mat& table_odds) {
  const cv::Rect box = cv::boundingRect(hypothesis.seeds);
  const int margin = std::max(12, static_cast<int>(0.2 * std::max(box.width, box.height)));
  const cv::Rect region =
      cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
      cv::Rect({0, 0}, image.size());
  FigureEvidence evidence;
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
  // Not more: matching smooths over the gap of a handle, where only the colour shows the table.
  evidence.log_odds.setTo(2, sure_figure);
  if (!table_odds.empty()) evidence.log_odds += table_odds(region);
  evidence.log_odds.setTo(-20, (others(region) | sides(region)) & ~seeds);

  cv::Mat mask = cv::Mat::zeros(image.size(), CV_8UC1);
  cut_figure(evidence).copyTo(mask(region));
  return parts_with_seeds(mask, hypothesis.seeds);
}

}  // namespace graspctx::detail
