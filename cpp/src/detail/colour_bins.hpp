#pragma once
#include <opencv2/core.hpp>

namespace graspctx::detail {

constexpr int hue_bins = 12, saturation_bins = 12, grey_bins = 12;
constexpr int colour_bins = hue_bins * saturation_bins + grey_bins;

/// The bin of a colour: hue and saturation, or grey where there is hardly any colour.
int colour_bin(int hue, int saturation, int value);

/// Hue, saturation and value, a little smoothed, CV_8UC3. Grey images have hue and saturation 0.
cv::Mat smooth_colours(const cv::Mat& image);

/// The bins of smooth_colours, CV_16UC1.
cv::Mat colour_indices(const cv::Mat& colours);

}  // namespace graspctx::detail
