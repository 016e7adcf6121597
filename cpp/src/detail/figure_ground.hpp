#pragma once
#include <opencv2/core.hpp>

namespace graspctx::detail {

/// What speaks for figure and ground in one region of the image. All of the same size.
struct FigureEvidence {
  cv::Mat image;         // CV_8UC3 or CV_8UC1
  cv::Mat log_odds;      // CV_32FC1: log of P(figure) / P(ground) from depth; 0 where nothing is known
  cv::Mat figure_seeds;  // CV_8UC1, > 0: pixels the figure's colours are learnt from
  cv::Mat ground_seeds;  // CV_8UC1, > 0: pixels the ground's colours are learnt from
};

/// Figure against ground by a graph cut: depth and colour (hue–saturation and grey histograms) as unaries,
/// smoothed over neighbours except across image edges (III-A, Fig. 2c). CV_8UC1, 255 = figure.
cv::Mat cut_figure(const FigureEvidence& evidence);

}  // namespace graspctx::detail
