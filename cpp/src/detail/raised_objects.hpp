#pragma once
#include <opencv2/core.hpp>

#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// Tells the objects apart that stand out of a table, touching and half hidden ones too. What hangs together
/// in depth in the image is one piece. Pieces that meet where neither the depth nor, between known depths,
/// the colour makes a step are one object: the inside of a plain object shows no depth.
///   raised       CV_8UC1, 255 = surely off the table
///   ground       CV_8UC1, 255 = surely table, or below
///   residual_px  CV_32FC1, disparity over the table's, known where raised
///   points_m     CV_32FC3, known where raised: where it is on the table, seen from right above, and its
///   height
///   options      its cell_m (what lies two cells apart from right above may be one object) and max_extent_m
/// Returns CV_32SC1: 0 = none, otherwise the number of the object,
/// from 1; `objects` is their number.
cv::Mat raised_objects(const cv::Mat& image, const cv::Mat& raised, const cv::Mat& ground,
                       const cv::Mat& residual_px, const cv::Mat& points_m,
                       const SegmentationOptions& options, int& objects);

}  // namespace graspctx::detail
