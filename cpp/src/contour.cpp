#include "graspctx/contour.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/imgproc.hpp>

#include "detail/check.hpp"

namespace graspctx {

namespace {

// Straight neighbours before diagonal ones: a chain then follows its edge without cutting corners.
constexpr std::array<std::array<int, 2>, 8> neighbours{
    {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};

std::vector<cv::Point> next_pixels(const cv::Mat& edges, const cv::Point& pixel) {
  std::vector<cv::Point> next;
  for (const auto& [du, dv] : neighbours) {
    const cv::Point q(pixel.x + du, pixel.y + dv);
    if (cv::Rect(0, 0, edges.cols, edges.rows).contains(q) && edges.at<uchar>(q)) next.push_back(q);
  }
  return next;
}

/// All edge pixels in the order of walking along the edges, open ends first, then what is left: loops.
std::vector<cv::Point> walk_along_edges(const cv::Mat& edge_image) {
  cv::Mat edges = edge_image.clone();
  std::vector<cv::Point> walked;
  for (const bool from_open_ends : {true, false}) {
    for (int v = 0; v < edges.rows; ++v) {
      for (int u = 0; u < edges.cols; ++u) {
        cv::Point pixel(u, v);
        if (!edges.at<uchar>(pixel)) continue;
        if (from_open_ends && next_pixels(edges, pixel).size() > 1) continue;
        while (true) {
          edges.at<uchar>(pixel) = 0;
          walked.push_back(pixel);
          const std::vector<cv::Point> next = next_pixels(edges, pixel);
          if (next.empty()) break;
          pixel = next.front();
        }
      }
    }
  }
  return walked;
}

/// How far each pixel is inside the mask: distance to the nearest pixel outside, 0 outside. All beyond the
/// image is outside.
cv::Mat distance_to_outside(const cv::Mat& mask, const cv::Size& size) {
  cv::Mat padded(size.height + 2, size.width + 2, CV_8UC1, cv::Scalar(0));
  cv::Mat inner = padded(cv::Rect({1, 1}, size));
  if (mask.empty()) {
    inner.setTo(255);
  } else {
    inner.setTo(255, mask);
  }
  cv::Mat distance;
  cv::distanceTransform(padded, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance(cv::Rect({1, 1}, size));
}

/// Where there are hardly any edges (no contrast, no texture) the mask's outline stands in.
void add_outline_if_bare(const cv::Mat& mask, cv::Mat& edges) {
  constexpr double enough_share = 0.25;  // of the outline's length
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  std::size_t outline_px = 0;
  for (const auto& outline : outlines) outline_px += outline.size();
  if (cv::countNonZero(edges) >= enough_share * static_cast<double>(outline_px)) return;
  for (const auto& outline : outlines) {
    for (const cv::Point& p : outline) edges.at<uchar>(p) = 255;
  }
}

}  // namespace

void ContourOptions::check() const {
  detail::require_option(
      std::isfinite(canny_low) && std::isfinite(canny_high) && canny_low >= 0 && canny_high >= canny_low,
      "Canny thresholds must be finite with 0 <= canny_low <= canny_high");
  detail::require_option(samples >= 0 && samples <= 1000000,
                         "samples must be 0 (every contour pixel) to 1000000");
  detail::require_option(mask_margin_px >= 0 && mask_margin_px <= 100, "mask_margin_px must be 0 to 100");
}

Contour sample_contour(const cv::Mat& image, const cv::Mat& mask, const ContourOptions& options) {
  options.check();
  detail::require_image(image, "image");
  if (!mask.empty()) detail::require_mask(mask, image.size(), "object mask");

  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::Mat du, dv, edges;
  cv::Sobel(grey, du, CV_16S, 1, 0, 3, 1, 0, cv::BORDER_REPLICATE);
  cv::Sobel(grey, dv, CV_16S, 0, 1, 3, 1, 0, cv::BORDER_REPLICATE);
  cv::Canny(du, dv, edges, options.canny_low, options.canny_high, /*L2gradient=*/true);

  // III-B: the contour of the segment. The edges come from the unmasked view: blacking out the background
  // would draw a false outline wherever the mask is wrong.
  if (!mask.empty()) {
    const cv::Mat object = mask > 0;
    const int side = 2 * options.mask_margin_px + 1;
    cv::Mat inside;
    cv::dilate(object, inside, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
    edges &= inside;
    add_outline_if_bare(object, edges);
  }

  // N samples with a uniform distribution: every (L/N)-th pixel along the edges. The same view gives the
  // same.
  const std::vector<cv::Point> pixels = walk_along_edges(edges);
  const std::size_t wanted = options.samples == 0 ? pixels.size() : static_cast<std::size_t>(options.samples);
  const std::size_t count = std::min(wanted, pixels.size());
  Contour contour;
  contour.points.reserve(count);
  contour.gradients_rad.reserve(count);
  contour.border_px.reserve(count);
  const cv::Mat distance_px = distance_to_outside(mask, image.size());
  for (std::size_t i = 0; i < count; ++i) {
    const cv::Point& p = pixels[(2 * i + 1) * pixels.size() / (2 * count)];
    contour.points.emplace_back(static_cast<float>(p.x), static_cast<float>(p.y));
    contour.gradients_rad.push_back(static_cast<float>(
        std::atan2(static_cast<double>(dv.at<short>(p)), static_cast<double>(du.at<short>(p)))));
    contour.border_px.push_back(distance_px.at<float>(p));
  }
  return contour;
}

}  // namespace graspctx
