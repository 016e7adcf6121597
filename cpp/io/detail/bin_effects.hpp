#pragma once
#include <Eigen/Core>

#include "graspctx/explanation.hpp"

namespace graspctx::detail {

/// Whether the outline has a histogram of its own.
inline bool has_outline(const GraspExplanation& explanation) {
  return explanation.descriptor.shape_context.outline_px > 0;
}

inline int window_px(const GraspExplanation& explanation, int window) {
  const PatchOptions& patch = explanation.descriptor.patch;
  return patch.patch_px * patch.windows_patches[static_cast<std::size_t>(window)];
}

using BinGrid = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The effects of one window's histogram, angle by ring: of all points, or of the outline alone.
inline BinGrid bin_grid(const GraspExplanation& explanation, int window, bool outline = false) {
  const ShapeContextOptions& shape = explanation.descriptor.shape_context;
  const int first = window * shape.bins() + (outline ? shape.angular_bins * shape.radial_bins : 0);
  return Eigen::Map<const BinGrid>(explanation.patch.bin_effects.data() + first, shape.angular_bins,
                                   shape.radial_bins);
}

/// The sum over all bins of a window.
inline double window_effect(const GraspExplanation& explanation, int window) {
  const int bins = explanation.descriptor.shape_context.bins();
  return explanation.patch.bin_effects.segment(window * bins, bins).sum();
}

}  // namespace graspctx::detail
