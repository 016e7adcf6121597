#pragma once
// Graphs of upright strips side by side, for tests of how regions are joined.
#include <cmath>

#include "blank_cues.hpp"
#include "detail/region_features.hpp"
#include "detail/regions.hpp"

namespace graspctx::testing {

/// A graph of which every region is foreground.
inline detail::RegionGraph all_foreground(const detail::SceneCues& cues,
                                          const detail::Superpixels& superpixels) {
  detail::RegionGraph graph = detail::region_graph(cues, superpixels);
  for (detail::Region& region : graph.regions) region.sums.foreground = region.sums.area;
  return graph;
}

/// Upright strips side by side, 10 px wide and 20 high, numbered from the left.
inline detail::RegionGraph strips(int count) {
  const cv::Size size(10 * count, 20);
  return all_foreground(blank_cues(size), tiles(size, {10, 20}));
}

/// Has a side of the union grown out of more than one strip?
inline bool grown(const detail::Features& features) {
  return std::exp(features[0]) > 210;
}

}  // namespace graspctx::testing
