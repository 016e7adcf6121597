#pragma once
#include <opencv2/core.hpp>

namespace graspctx::detail {

/// The image as grey levels, CV_8UC1.
cv::Mat grey(const cv::Mat& image);

/// Standard deviation (grey levels) of the noise of a CV_8UC1 image; not less than that of rounding.
double noise_sigma(const cv::Mat& grey_image);

/// Where a window can be placed along its row: CV_8UC1, 255 where the root mean square of the horizontal
/// gradient in 7x7 is at least `sigmas` times what noise alone would give.
cv::Mat horizontal_texture(const cv::Mat& grey_image, double sigmas);

}  // namespace graspctx::detail
