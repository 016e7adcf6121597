#pragma once
#include "detail/check.hpp"
#include "graspctx/stereo.hpp"

namespace graspctx::detail {

/// A pair of equal size and type with the disparity maps of its left view, or InvalidInput.
inline void require_scene(const RectifiedPair& pair, const Disparity& disparity) {
  require_image(pair.left, "left image");
  require_image(pair.right, "right image");
  if (pair.left.size() != pair.right.size() || pair.left.type() != pair.right.type()) {
    throw InvalidInput("stereo pair: expected two images of the same size and type, got left " +
                       describe(pair.left) + " and right " + describe(pair.right));
  }
  for (const cv::Mat* map : {&disparity.dense, &disparity.reliable}) {
    if (map->type() != CV_32FC1 || map->size() != pair.left.size()) {
      throw InvalidInput("disparity: expected a CV_32FC1 map of the images' size, " + describe(pair.left) +
                         ", got " + describe(*map));
    }
  }
}

}  // namespace graspctx::detail
