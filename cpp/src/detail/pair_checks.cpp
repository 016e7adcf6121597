#include "detail/pair_checks.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "detail/number_text.hpp"
#include "detail/quantile.hpp"
#include "detail/texture.hpp"
#include "detail/vertical_offset.hpp"

namespace graspctx::detail {

namespace {

/// The pixels that any matcher finds in a second view of the same scene.
struct TexturedPixels {
  double share_of_image = 0;
  double reliable_share = 0;  // of them. Both views agree on it; in views of different scenes, or swapped
                              // ones, they hardly ever do.
  double largest_px = 0;      // 99th percentile of their disparities without sign
};

TexturedPixels textured_pixels(const cv::Mat& left, const Disparity& disparity) {
  constexpr double texture_sigmas = 3;  // well textured: a failure there is the pair's, not the table's
  const cv::Mat textured = horizontal_texture(left, texture_sigmas);
  int all = 0;
  std::vector<float> sizes_px;
  for (int v = 0; v < left.rows; ++v) {
    const auto* reliable = disparity.reliable.ptr<float>(v);
    const auto* here = textured.ptr<uchar>(v);
    // The leftmost columns may lie outside the right view.
    for (int u = left.cols / 8; u < left.cols; ++u) {
      if (!here[u]) continue;
      ++all;
      if (!std::isnan(reliable[u])) sizes_px.push_back(std::abs(reliable[u]));
    }
  }
  TexturedPixels result;
  result.share_of_image = all / static_cast<double>(left.total());
  result.reliable_share = all > 0 ? static_cast<double>(sizes_px.size()) / all : 0;
  result.largest_px = sizes_px.empty() ? 0 : quantile(std::move(sizes_px), 0.99);
  return result;
}

/// Is nothing larger to be seen than specks? Dust and hot pixels agree between the views by chance, and the
/// outline of an object is longer.
bool shows_specks_only(const cv::Mat& left) {
  constexpr double texture_sigmas = 3, largest_share_of_width = 0.04;
  cv::Mat textured = horizontal_texture(left.t(), texture_sigmas).t(), labels, boxes, centroids;
  textured |= horizontal_texture(left, texture_sigmas);
  const int components = cv::connectedComponentsWithStats(textured, labels, boxes, centroids);
  for (int i = 1; i < components; ++i) {
    const int side = std::max(boxes.at<int>(i, cv::CC_STAT_WIDTH), boxes.at<int>(i, cv::CC_STAT_HEIGHT));
    if (side > largest_share_of_width * left.cols) return false;
  }
  return true;
}

std::string rounded(double value, double step) {
  // A whole number of tenths or hundredths over ten or a hundred is the number that is written so.
  return number_text(std::round(value / step) / std::round(1 / step));
}

/// What is to be said about rows that do not correspond. Real pairs that are rectified well are within 0.2
/// px; from a pixel on disparities get lost, and those of slanted edges are wrong by as much.
std::vector<std::string> misalignments(const VerticalOffset& measured, int width_px) {
  constexpr double least_px = 0.7, degree = CV_PI / 180;
  std::vector<std::string> found;
  if (std::abs(measured.offset_px) >= least_px) {
    found.push_back("the views are misaligned vertically by " + rounded(std::abs(measured.offset_px), 0.1) +
                    " px, the right one is too " + (measured.offset_px > 0 ? "low" : "high") +
                    ": calibrate and rectify them anew");
  }
  if (std::abs(std::tan(measured.rotation_rad)) * width_px / 2 >= least_px) {
    found.push_back("the right view is turned by " + rounded(std::abs(measured.rotation_rad) / degree, 0.01) +
                    " degrees against the left one: calibrate and rectify them anew");
  }
  return found;
}

}  // namespace

PairChecks check_pair(const RectifiedPair& pair, const Disparity& disparity, double min_reliable_share) {
  constexpr double least_textured_share = 0.0005;  // an object's outline at least
  constexpr double no_disparity_px = 0.5;
  PairChecks checks;
  const cv::Mat left = grey(pair.left);
  const TexturedPixels textured = textured_pixels(left, disparity);
  if (textured.share_of_image < least_textured_share) {
    checks.refusal = "the left view shows hardly any texture: there is nothing to match";
    return checks;
  }
  constexpr double sparse_share = 0.02;
  if (textured.share_of_image < sparse_share && shows_specks_only(left)) {
    checks.refusal = "the left view shows nothing but specks: there is no outline to match";
    return checks;
  }
  const auto measured = measure_vertical_offset(pair, disparity);
  if (measured) {
    checks.vertical_offset_px = measured->offset_px;
    checks.warnings = misalignments(*measured, pair.left.cols);
  }
  if (textured.reliable_share < min_reliable_share) {
    checks.refusal = "only " + std::to_string(static_cast<int>(100 * textured.reliable_share)) +
                     " % of the textured pixels agree between the views: not a rectified stereo pair of one "
                     "scene, left view first";
  } else if (textured.largest_px < no_disparity_px) {
    checks.refusal = "the two views are the same picture: there is no depth in them";
  }
  return checks;
}

}  // namespace graspctx::detail
