#include "detail/colour_bins.hpp"

#include <opencv2/imgproc.hpp>

namespace graspctx::detail {

int colour_bin(int hue, int saturation, int value) {
  constexpr int least_chroma = 20;  // saturation · value: below, hue is noise
  if (saturation * value / 255 < least_chroma) return hue_bins * saturation_bins + value * grey_bins / 256;
  return (hue * hue_bins / 256) * saturation_bins + saturation * saturation_bins / 256;
}

cv::Mat smooth_colours(const cv::Mat& image) {
  cv::Mat smooth, colours;
  cv::GaussianBlur(image, smooth, {3, 3}, 0);
  if (image.channels() == 1) cv::cvtColor(smooth, smooth, cv::COLOR_GRAY2BGR);
  cv::cvtColor(smooth, colours, cv::COLOR_BGR2HSV_FULL);
  return colours;
}

cv::Mat colour_indices(const cv::Mat& colours) {
  cv::Mat indices(colours.size(), CV_16UC1);
  for (int v = 0; v < colours.rows; ++v) {
    for (int u = 0; u < colours.cols; ++u) {
      const auto& pixel = colours.at<cv::Vec3b>(v, u);
      indices.at<ushort>(v, u) = static_cast<ushort>(colour_bin(pixel[0], pixel[1], pixel[2]));
    }
  }
  return indices;
}

}  // namespace graspctx::detail
