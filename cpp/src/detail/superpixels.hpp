#pragma once
#include <opencv2/core.hpp>

namespace graspctx::detail {

/// An image cut into small regions of one colour: no outline of an object runs through one, or hardly any.
struct Superpixels {
  cv::Mat labels;  // CV_32SC1, from 0
  int count = 0;
};

/// Graph-based segmentation (Felzenszwalb and Huttenlocher 2004): regions grow together over the weakest
/// edges first, as long as the edge is no stronger than what either region holds inside, plus a slack that
/// falls with its size. image: CV_8UC1 or CV_8UC3, some 640 px wide.
Superpixels find_superpixels(const cv::Mat& image);

}  // namespace graspctx::detail
