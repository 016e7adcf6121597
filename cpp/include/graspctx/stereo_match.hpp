#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "graspctx/export.hpp"
#include "graspctx/fovea.hpp"

namespace graspctx {

struct GRASPCTX_EXPORT StereoMatchOptions {
  int window_px = 21;            // odd, of the foveal view
  double search_px = 30;         // either side of the fixated (zero) disparity, in the foveal view
  double min_correlation = 0.6;  // normalised cross-correlation
  void check() const;
};

/// A point of the left foveal view found again in the right one.
struct StereoMatch {
  Eigen::Vector2d left_view_px, right_view_px;  // foveal views
  double disparity_px = 0;                      // of the full-size pair: u_left − u_right
  double disparity_stddev_px = 0;               // from the curvature of the correlation
  double correlation = 0;
};

/// Match a patch of the left foveal view along its row in the right one, to sub-pixel (III-D).
/// Nothing if the best correlation is too low or lies at the end of the search.
GRASPCTX_EXPORT std::optional<StereoMatch> match_patch(const FovealPair& pair,
                                                       const Eigen::Vector2d& left_view_px, double prior_px,
                                                       const StereoMatchOptions& options = {});

}  // namespace graspctx
