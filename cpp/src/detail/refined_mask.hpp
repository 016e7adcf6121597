#pragma once
#include <opencv2/core.hpp>

namespace graspctx::detail {

/// A mask without what it has too much: figure and ground are cut apart by their colours (III-A; GrabCut:
/// Rother, Kolmogorov and Blake 2004), and those parts of the ground are taken away that the image's edges
/// part from the figure, not from what is outside. image CV_8UC3 or CV_8UC1; mask CV_8UC1 of its size, > 0 =
/// object. Returns CV_8UC1, 255 = object; the mask itself where there is nothing to learn colours from.
cv::Mat refined_mask(const cv::Mat& image, const cv::Mat& mask);

}  // namespace graspctx::detail
