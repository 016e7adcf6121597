#pragma once
#include <opencv2/core.hpp>
#include <vector>

#include "graspctx/export.hpp"

namespace graspctx {

struct GRASPCTX_EXPORT ContourOptions {
  double canny_low = 20, canny_high = 60;  // hysteresis thresholds of the gradient magnitude (Sobel 3×3)
  int samples = 300;                       // spread evenly along the contour; 0: every contour pixel
  int mask_margin_px = 2;                  // edges this far outside the mask still count as the outline
  void check() const;
};

/// Samples of an object's contour: its outline and its inner edges (III-B, Fig. 3).
struct Contour {
  std::vector<cv::Point2f> points;   // (u, v) px
  std::vector<float> gradients_rad;  // direction of the intensity gradient, from +u towards +v, in (−π, π]
  std::vector<float> border_px;  // distance to the nearest pixel outside the mask, 0 outside it; without a
                                 // mask: to the border of the image
};

/// Canny on the unmasked image, the edges inside the mask, sampled evenly and deterministically along the
/// edges. Where there are hardly any edges the mask's outline stands in. Image CV_8UC3 or CV_8UC1; mask
/// CV_8UC1 of the same size, > 0 = object, or empty for the whole image. Throws InvalidInput otherwise.
GRASPCTX_EXPORT Contour sample_contour(const cv::Mat& image, const cv::Mat& mask,
                                       const ContourOptions& options = {});

}  // namespace graspctx
