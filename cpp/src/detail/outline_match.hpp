#pragma once
#include <opencv2/core.hpp>
#include <vector>

#include "graspctx/stereo.hpp"

namespace graspctx::detail {

/// Disparity of a point on an outline, at full resolution.
struct OutlineMatch {
  double u, v;  // left view, px
  double disparity_px;
  double sigma_px;  // from the images' noise and the contrast of the outline
};

/// Disparities along the outline of a plain region (CV_8UC1, 255 = region), where the region ends in an edge
/// that is not nearly horizontal. Only the edge and the region's own side are compared, in rows that follow
/// the edge: what lies beyond belongs to another depth where the region is a table and beyond is the floor.
/// The edge belongs to what is nearer. At most one match for each run of the region in a row, with a
/// disparity up to most_px; what matches in several places is left out.
std::vector<OutlineMatch> match_outline(const RectifiedPair& pair, const cv::Mat& region, int most_px);

}  // namespace graspctx::detail
