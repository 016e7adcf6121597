#pragma once
#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

namespace graspctx::detail {

/// Where an object may be: pixels that are surely its own.
struct Hypothesis {
  cv::Mat seeds;            // CV_8UC1 of the image's size, 255 = the hypothesis
  double disparity_px = 0;  // median, where the view is fixated
  double saliency = 0;
};

/// The most salient first; equals keep their order.
inline void sort_by_saliency(std::vector<Hypothesis>& hypotheses) {
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const auto& a, const auto& b) { return a.saliency > b.saliency; });
}

}  // namespace graspctx::detail
