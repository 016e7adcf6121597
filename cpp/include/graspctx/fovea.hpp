#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "graspctx/export.hpp"
#include "graspctx/stereo.hpp"

namespace graspctx {

struct GRASPCTX_EXPORT FoveaOptions {
  int object_px = 200;       // longer side of the object's bounding box in the foveal view
  int margin_px = 40;        // around the box
  bool refine_mask = false;  // cut figure and ground apart by colour first: a mask that is too large, takes
                             // a part of the table along or lacks one of the object is brought to the object
  void check() const;
};

/// A view re-sampled around one object at a fixed object size (METHOD 2, fovea).
///   view_px = scale · (image_px − origin_px)
struct FovealView {
  cv::Mat image;                    // CV_8UC3 or CV_8UC1
  cv::Mat mask;                     // CV_8UC1, 255 = object
  double scale = 1;                 // view pixels per image pixel
  Eigen::Vector2d origin_px{0, 0};  // image pixel at the view's (0, 0)

  Eigen::Vector2d view_from_image(const Eigen::Vector2d& image_px) const {
    return scale * (image_px - origin_px);
  }
  Eigen::Vector2d image_from_view(const Eigen::Vector2d& view_px) const {
    return view_px / scale + origin_px;
  }
};

/// Both views of one object, alike in size and scale; the right one is shifted so that the object's median
/// disparity is zero (fixation). The pair stays rectified.
struct FovealPair {
  FovealView left, right;
  double fixation_disparity_px = 0;  // origin_left.u − origin_right.u
};

/// The foveal view of the object that `mask` (CV_8UC1, > 0 = object) marks. Throws InvalidInput if the mask
/// is empty, or its size or type is wrong.
GRASPCTX_EXPORT FovealView foveal_view(const cv::Mat& image, const cv::Mat& mask,
                                       const FoveaOptions& options = {});

/// The foveal pair of the object that `object_mask` marks in the left view; its mask in the right view is
/// carried over by the disparity. Nothing if the object has no disparity.
GRASPCTX_EXPORT std::optional<FovealPair> foveal_pair(const RectifiedPair& pair, const cv::Mat& object_mask,
                                                      const cv::Mat& disparity,
                                                      const FoveaOptions& options = {});

}  // namespace graspctx
