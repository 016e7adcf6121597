#include "detail/plain_table_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detail/figure_ground.hpp"
#include "detail/masks.hpp"
#include "detail/plain_table_shadow.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/quantile.hpp"

namespace graspctx::detail {

namespace {

constexpr int least_figure_px = 40;

/// The pixels along an outline are a mixture; the outer ones, nearer to the table's colour than to that of
/// the figure just inside, are taken off.
cv::Mat without_mixed_edge(const cv::Mat& figure, const cv::Mat& sigmas) {
  constexpr int mixed_px = 3;
  cv::Mat inside, strongest, result = figure.clone();
  sigmas.copyTo(inside, figure);
  cv::dilate(inside, strongest,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * mixed_px + 1, 2 * mixed_px + 1}));
  const cv::Mat is_mixed = sigmas < 0.5 * strongest;
  for (int round = 0; round < mixed_px; ++round) {
    cv::Mat inner;
    cv::erode(result, inner, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
    result &= inner | ~is_mixed;
  }
  return result;
}

/// The median of what is known in a mask; nothing if nothing is.
std::optional<double> median_disparity(const cv::Mat& mask, const cv::Mat& reliable) {
  std::vector<float> known;
  for (const cv::Point& pixel : where(mask)) {
    const float d = reliable.at<float>(pixel);
    if (!std::isnan(d)) known.push_back(d);
  }
  if (known.empty()) return std::nullopt;
  return median(std::move(known));
}

/// The pixels of a figure where the table's extent ends.
cv::Mat at_border(const cv::Mat& figure, const PlainTable& table) {
  constexpr int edge_px = 3;
  return figure & grown(~table.extent, edge_px);
}

/// What a figure that stands across the table's far edge goes on as beyond it: what has its depth and its
/// colour, cut from the background.
cv::Mat with_part_beyond(const cv::Mat& figure, const cv::Mat& image, const PlainTable& table,
                         const Disparity& disparity) {
  constexpr int least_contact_px = 4;
  const cv::Mat beyond = ~table.extent, contact = at_border(figure, table);
  if (cv::countNonZero(contact) < least_contact_px) return figure;
  const auto own_px = median_disparity(figure & grown(contact, 40), disparity.dense);
  if (!own_px) return figure;

  const cv::Rect box = cv::boundingRect(figure);
  const int margin = std::max(box.width, box.height);
  const cv::Rect region =
      cv::Rect(box.x - margin / 2, box.y - margin, box.width + margin, box.height + margin + margin / 2) &
      cv::Rect({0, 0}, image.size());
  const double band_px = std::max(1.5, 0.05 * *own_px);
  cv::Mat same(image.size(), CV_8UC1), other(image.size(), CV_8UC1);
  for (int v = region.y; v < region.br().y; ++v) {
    for (int u = region.x; u < region.br().x; ++u) {
      const double apart = disparity.dense.at<float>(v, u) - *own_px;
      same.at<uchar>(v, u) = std::abs(apart) < band_px ? 255 : 0;
      other.at<uchar>(v, u) = std::abs(apart) > 1.5 * band_px ? 255 : 0;
    }
  }
  FigureEvidence evidence;
  evidence.image = image(region);
  const cv::Mat mine = figure(region), outside = beyond(region), near = grown(mine, margin / 2);
  evidence.figure_seeds = mine;
  evidence.ground_seeds = outside & other(region);
  if (cv::countNonZero(evidence.ground_seeds) < 50) return figure;  // nothing to tell it from
  evidence.log_odds = cv::Mat(region.size(), CV_32FC1, cv::Scalar(-0.3));
  evidence.log_odds.setTo(2, same(region));
  evidence.log_odds.setTo(-2, other(region));
  evidence.log_odds.setTo(-20, ~outside | ~near);
  evidence.log_odds.setTo(20, mine);
  cv::Mat whole = cv::Mat::zeros(image.size(), CV_8UC1);
  cut_figure(evidence).copyTo(whole(region));
  return parts_with_seeds(whole, figure);
}

/// Figures with the inside that colour took for table filled: a gradient of shading goes through the table's
/// colour somewhere, but what is bare table has it all over.
cv::Mat with_insides(const cv::Mat& figures, const cv::Mat& sigmas, const cv::Mat& shadow) {
  constexpr int least_hole_px = 15, edge_px = 2;
  constexpr float most_sigmas = 2;  // the largest of the channels', for bare table 1.2 in the median
  cv::Mat labels, stats, centres, filled = figures.clone();
  const int count = cv::connectedComponentsWithStats(~figures, labels, stats, centres, 4, CV_32S);
  for (int label = 1; label < count; ++label) {
    const cv::Rect box(stats.at<int>(label, cv::CC_STAT_LEFT), stats.at<int>(label, cv::CC_STAT_TOP),
                       stats.at<int>(label, cv::CC_STAT_WIDTH), stats.at<int>(label, cv::CC_STAT_HEIGHT));
    const int area_px = stats.at<int>(label, cv::CC_STAT_AREA);
    if (box.x == 0 || box.y == 0 || box.br().x == figures.cols || box.br().y == figures.rows ||
        area_px > static_cast<int>(figures.total() / 8)) {
      continue;  // around the figures, not within one
    }
    const cv::Mat hole = labels(box) == label;
    std::vector<float> apart;
    for (const cv::Point& pixel : where(shrunk(hole, edge_px) & ~shadow(box))) {
      apart.push_back(sigmas.at<float>(pixel + box.tl()));
    }
    if (area_px < least_hole_px || (!apart.empty() && median(std::move(apart)) > most_sigmas)) {
      filled(box).setTo(255, hole);
    }
  }
  return filled;
}

/// The connected figures of a mask, the largest first, each with the scraps beside it: where something thin
/// has the table's colour for a few pixels it is still one thing.
std::vector<cv::Mat> figures_with_scraps(const cv::Mat& mask) {
  constexpr int gap_px = 4;
  constexpr double largest_scrap = 0.125;  // of the figure; what is larger may be an object of its own
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centres, 8, CV_32S);
  std::vector<int> by_area;
  for (int label = 1; label < count; ++label) by_area.push_back(label);
  const auto area_px = [&](int label) { return stats.at<int>(label, cv::CC_STAT_AREA); };
  std::stable_sort(by_area.begin(), by_area.end(), [&](int a, int b) { return area_px(a) > area_px(b); });
  std::vector<char> taken(std::size_t(count), 0);
  std::vector<cv::Mat> figures;
  for (const int label : by_area) {
    if (taken[std::size_t(label)]) continue;
    cv::Mat figure = labels == label;
    taken[std::size_t(label)] = 1;
    for (bool joined = true; joined;) {  // scraps lead to others
      joined = false;
      for (const cv::Point& pixel : where(grown(figure, gap_px) & mask & ~figure)) {
        const int other = labels.at<int>(pixel);
        if (taken[std::size_t(other)] || area_px(other) > largest_scrap * area_px(label)) continue;
        taken[std::size_t(other)] = 1;
        figure |= labels == other;
        joined = true;
      }
    }
    figures.push_back(figure);
  }
  return figures;
}

/// Does stereo see a figure, or its outline, stand out of the table? What is painted on it does not.
bool has_relief(const cv::Mat& figure, const Relief& relief) {
  constexpr float least_px = 0.25F, least_sigmas = 2.5F, below_px = -1;
  constexpr int least_raised_px = 15;
  constexpr double least_share = 0.2;
  int known = 0, raised = 0, below = 0;
  for (const cv::Point& pixel : where(grown(figure, 1))) {
    const float residual = relief.residual_px.at<float>(pixel), sigma = relief.sigma_px.at<float>(pixel);
    if (std::isnan(residual)) continue;
    ++known;
    raised += residual > std::max(least_px, least_sigmas * sigma) ? 1 : 0;
    below += residual < below_px ? 1 : 0;
  }
  return raised >= least_raised_px && raised > least_share * known && raised > below;
}

/// Does a figure run along the table's border, rather than stand across it? That is background of about the
/// table's colour, of which the table's extent took a strip along.
bool runs_along_border(const cv::Mat& figure, const PlainTable& table) {
  constexpr double least_share = 0.15;
  return cv::countNonZero(at_border(figure, table)) > least_share * cv::countNonZero(figure);
}

/// Does a figure reach farther than any object does?
bool is_too_large(const cv::Mat& figure, double disparity_px, const StereoCamera& camera,
                  const SegmentationOptions& options) {
  std::vector<cv::Point> points;
  cv::findNonZero(figure, points);
  const cv::RotatedRect box = cv::minAreaRect(points);
  const double shorter_m =
      std::min(box.size.width, box.size.height) * camera.depth_m(disparity_px) / camera.focal_px;
  return shorter_m > std::max(options.max_extent_m, options.max_height_m);
}

}  // namespace

bool lies_on_plane(const PlainTable& table, const Relief& relief) {
  constexpr float within_px = 0.7F, below_px = -1.5F;
  constexpr int outline_px = 4, least_known_px = 50;
  int known = 0, on = 0, below = 0;
  for (const cv::Point& pixel : where(plain_table_outline(table, outline_px) & table.extent)) {
    const float residual = relief.residual_px.at<float>(pixel);
    if (std::isnan(residual)) continue;
    ++known;
    on += std::abs(residual) < within_px ? 1 : 0;
    below += residual < below_px ? 1 : 0;
  }
  return known >= least_known_px && on > 0.04 * known && below < 0.25 * known;
}

bool outweighs_plane(const PlainTable& table, const Relief& relief) {
  const int plain_px = cv::countNonZero(table.region);
  const int on_plane_px = cv::countNonZero((cv::abs(relief.residual_px) < 0.5) & ~table.extent);
  return plain_px > on_plane_px;
}

std::vector<cv::Mat> figures_on_plain_table(const RectifiedPair& pair, const Disparity& disparity,
                                            const PlainTable& table, const Relief* relief,
                                            const StereoCamera& camera, const SegmentationOptions& options) {
  cv::Mat bgr = pair.left;
  if (bgr.channels() == 1) cv::cvtColor(pair.left, bgr, cv::COLOR_GRAY2BGR);
  const auto anywhere_px = median_disparity(table.extent, disparity.reliable);
  if (!anywhere_px) return {};  // nothing that stereo sees: a picture of a wall, or of nothing
  const TableComparison compared = compare_with_table(bgr, table);
  constexpr double surely_off = 8, probably_off = 4.5;
  constexpr int least_sure_px = 15;
  cv::Mat off_table = compared.sigmas > probably_off;
  off_table = parts_holding(off_table, compared.sigmas > surely_off, least_sure_px);
  const cv::Mat shadow = shadows_on_plain_table(compared, off_table, table, relief);
  cv::Mat objects = without_mixed_edge(off_table & ~shadow, compared.sigmas) & table.extent;
  cv::morphologyEx(objects, objects, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
  objects = with_insides(objects, compared.sigmas, shadow);

  std::vector<cv::Mat> found;
  for (const cv::Mat& figure : figures_with_scraps(objects)) {
    if (cv::countNonZero(figure) < least_figure_px) continue;
    const auto own_px = median_disparity(grown(figure, 1), disparity.reliable);
    if (runs_along_border(figure, table)) continue;
    if (relief != nullptr && !has_relief(figure, *relief)) continue;
    if (is_too_large(figure, own_px.value_or(*anywhere_px), camera, options)) continue;
    found.push_back(with_part_beyond(figure, bgr, table, disparity));
  }
  return found;
}

}  // namespace graspctx::detail
