#pragma once
#include <opencv2/core.hpp>

#include "graspctx/camera.hpp"
#include "graspctx/export.hpp"

namespace graspctx {

/// Two rectified views of the same size and type, CV_8UC3 (BGR) or CV_8UC1: rows correspond.
struct RectifiedPair {
  cv::Mat left, right;
};

/// Check a pair of images against the camera and rectify it where camera.raw says so (METHOD 1; paper II).
/// Throws InvalidInput for empty images, other types, different sizes, or a size other than the
/// calibration's.
GRASPCTX_EXPORT RectifiedPair rectify(const cv::Mat& left, const cv::Mat& right, const StereoCamera& camera);

struct GRASPCTX_EXPORT DisparityOptions {
  // Of the full-size images, rounded up to a multiple of 16; at most 4064, or 2032 at full resolution; 0: a
  // quarter of the width.
  int max_disparity_px = 0;
  bool half_resolution = true;  // match at half size, and scale the disparities back
  int block_px = 3;             // odd
  double uniqueness_percent = 10;
  int speckle_px = 50;          // smaller components of like disparity are dropped
  double left_right_px = 1.0;   // reliable: largest difference between left and right disparity
  double texture_sigmas = 1.5;  // reliable: least horizontal gradient (rms in 7x7), pure noise = 1
  void check() const;
};

/// Disparity maps of the left view, CV_32FC1, px of the full-size image, NaN where unknown.
struct Disparity {
  cv::Mat dense;     // all the matcher gave
  cv::Mat reliable;  // left-right consistent and textured
};

/// Semi-global matching of a rectified pair (OpenCV's SGBM). Throws InvalidInput for bad images or options.
GRASPCTX_EXPORT Disparity compute_disparity(const RectifiedPair& pair, const DisparityOptions& options = {});

/// Half resolution for the scene, full resolution where it matters: match the pixels of each object again, in
/// the full-size images. What contradicts the coarse map by more than its pixel is not taken over. With
/// options.half_resolution false there is nothing to refine. instance_ids: CV_8UC1 of the image's size, 0 =
/// background. Throws InvalidInput for maps or masks of another size or type.
GRASPCTX_EXPORT Disparity refine_disparity(const RectifiedPair& pair, const Disparity& disparity,
                                           const cv::Mat& instance_ids, const DisparityOptions& options = {});

}  // namespace graspctx
