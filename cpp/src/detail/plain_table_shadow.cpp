#include "detail/plain_table_shadow.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "detail/masks.hpp"

namespace graspctx::detail {

namespace {

constexpr int channels = 3;

/// Pixels without texture or edges of their own.
cv::Mat flat_light(const TableComparison& compared) {
  const double most = std::max(0.03, 5 * compared.light_noise);
  cv::Mat du, dv, slope;
  cv::filter2D(compared.light, du, CV_32F, cv::Matx<float, 1, 5>(-1, 0, 0, 0, 1), {-1, -1}, 0,
               cv::BORDER_REPLICATE);
  cv::filter2D(compared.light, dv, CV_32F, cv::Matx<float, 5, 1>(-1, 0, 0, 0, 1), {-1, -1}, 0,
               cv::BORDER_REPLICATE);
  cv::magnitude(du, dv, slope);
  return slope < most;
}

/// A flat piece of what could be shadow.
struct Piece {
  int label = 0, area_px = 0;
  double light = 0;
};

/// The light in most of the pieces' pixels: shadows of one lamp leave the same share everywhere.
double commonest_light(const std::vector<Piece>& pieces) {
  constexpr int bins = 200;
  std::array<double, bins + 1> weights{};
  for (const Piece& piece : pieces) {
    const int middle = static_cast<int>(piece.light * bins);
    for (int bin = middle - 3; bin <= middle + 3; ++bin) {
      if (bin >= 0 && bin <= bins) weights[std::size_t(bin)] += piece.area_px * (4 - std::abs(bin - middle));
    }
  }
  return (double(std::max_element(weights.begin(), weights.end()) - weights.begin()) + 0.5) / bins;
}

/// A piece of shadow and its edge, where the light comes back.
cv::Mat with_lighter_edge(const cv::Mat& piece, const cv::Mat& lighter, int edge_px) {
  cv::Mat whole = piece.clone();
  for (int step = 0; step < edge_px; ++step) whole |= grown(whole, 1) & lighter;
  return whole;
}

/// Does stereo see an outline above the table, rather than on it? band: CV_8UC1 of the box's size, on the
/// outline.
bool stands_out(const cv::Rect& box, const cv::Mat& band, const Relief& relief) {
  constexpr float least_px = 0.5F, least_sigmas = 3, most_sigma_px = 0.4F;
  constexpr int least_known_px = 15;
  int above = 0, on = 0;
  for (const cv::Point& pixel : where(grown(band, 2))) {
    const cv::Point at = pixel + box.tl();
    const float residual = relief.residual_px.at<float>(at), sigma = relief.sigma_px.at<float>(at);
    if (std::isnan(residual) || !(sigma < most_sigma_px)) continue;
    (residual > std::max(least_px, least_sigmas * sigma) ? above : on) += 1;
  }
  return above >= least_known_px && above > on;
}

}  // namespace

TableComparison compare_with_table(const cv::Mat& image, const PlainTable& table) {
  constexpr double blur_px = 0.8;
  constexpr double least_sigma = 0.75;  // shading goes in steps of grey levels
  const double averaged = 2 * std::sqrt(CV_PI) * blur_px;
  TableComparison compared;
  cv::Mat smooth;
  image.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {0, 0}, blur_px);
  cv::Vec3f inverse_sigma;
  double noise = 0;
  for (int c = 0; c < channels; ++c) {
    const double sigma = std::max(least_sigma, table.sigma[c] / averaged);
    inverse_sigma[c] = static_cast<float>(1 / sigma);
    noise = std::max(noise, sigma);
  }
  compared.sigmas.create(image.size(), CV_32FC1);
  compared.light.create(image.size(), CV_32FC1);
  compared.off_hue.create(image.size(), CV_32FC1);
  double brightness = 0;
  for (int v = 0; v < image.rows; ++v) {
    const auto* seen = smooth.ptr<cv::Vec3f>(v);
    const auto* bare = table.colour.ptr<cv::Vec3f>(v);
    for (int u = 0; u < image.cols; ++u) {
      const cv::Vec3f apart = seen[u] - bare[u];
      compared.sigmas.at<float>(v, u) =
          std::max({std::abs(apart[0]) * inverse_sigma[0], std::abs(apart[1]) * inverse_sigma[1],
                    std::abs(apart[2]) * inverse_sigma[2]});
      const float energy = std::max(bare[u].dot(bare[u]), 1.0F);
      const float light = seen[u].dot(bare[u]) / energy;
      compared.light.at<float>(v, u) = light;
      const cv::Vec3f rest = seen[u] - light * bare[u];
      compared.off_hue.at<float>(v, u) = std::sqrt(rest.dot(rest) / energy);
      brightness += std::sqrt(energy);
    }
  }
  compared.light_noise = noise / (brightness / double(image.total()));
  return compared;
}

cv::Mat shadows_on_plain_table(const TableComparison& compared, const cv::Mat& off_table,
                               const PlainTable& table, const Relief* relief) {
  constexpr double darkest = 0.15, lightest = 0.97, least_beside_table = 0.15;
  const double most_off_hue = 0.04 + 4 * compared.light_noise;
  const double same_light = 0.03 + 2 * compared.light_noise;
  const cv::Mat table_like =
      (compared.off_hue < most_off_hue) & (compared.light > darkest) & (compared.light < 1.02) & off_table;
  const cv::Mat could_be = table_like & table.extent & (compared.light < lightest);
  cv::Mat labels, stats, centres;
  const int count =
      cv::connectedComponentsWithStats(could_be & flat_light(compared), labels, stats, centres, 4, CV_32S);
  std::vector<Piece> pieces;
  constexpr int least_px = 20, edge_px = 6;
  for (int label = 1; label < count; ++label) {
    const int area_px = stats.at<int>(label, cv::CC_STAT_AREA);
    if (area_px < least_px) continue;
    const int x = stats.at<int>(label, cv::CC_STAT_LEFT) - edge_px - 2;
    const int y = stats.at<int>(label, cv::CC_STAT_TOP) - edge_px - 2;
    const cv::Rect box = cv::Rect(x, y, stats.at<int>(label, cv::CC_STAT_WIDTH) + 2 * edge_px + 4,
                                  stats.at<int>(label, cv::CC_STAT_HEIGHT) + 2 * edge_px + 4) &
                         cv::Rect({0, 0}, labels.size());
    const cv::Mat piece = labels(box) == label;
    cv::Scalar mean, spread;
    cv::meanStdDev(compared.light(box), mean, spread, piece);
    if (spread[0] > same_light) continue;
    const cv::Mat whole =
        with_lighter_edge(piece, table_like(box) & (compared.light(box) > mean[0] - same_light), edge_px);
    const cv::Mat ring = grown(whole, 1) & ~whole;
    const double beside_table =
        double(cv::countNonZero(ring & ~off_table(box))) / std::max(1, cv::countNonZero(ring));
    if (beside_table < least_beside_table) continue;
    if (relief != nullptr && stands_out(box, ring & ~off_table(box), *relief)) continue;
    pieces.push_back({label, area_px, mean[0]});
  }
  cv::Mat shadow = cv::Mat::zeros(off_table.size(), CV_8UC1);
  if (pieces.empty()) return shadow;
  const double light = commonest_light(pieces);
  for (const Piece& piece : pieces) {
    if (std::abs(piece.light - light) < same_light) shadow |= labels == piece.label;
  }
  return with_lighter_edge(shadow, table_like & (compared.light > light - same_light), edge_px);
}

}  // namespace graspctx::detail
