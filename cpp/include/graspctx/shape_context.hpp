#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "graspctx/export.hpp"

namespace graspctx {

/// Rows of numbers, row-major: one row for each point or patch.
using FeatureMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct GRASPCTX_EXPORT ShapeContextOptions {
  int angular_bins = 8, radial_bins = 5;
  double inner_radius = 0.125, outer_radius = 2.0;  // in units of the mean pairwise distance
  bool relative_to_gradient = false;                // turn each histogram by its sample's gradient direction
  int outline_px = 0;  // points this close to the mask's border are its outline: a second histogram counts
                       // those alone; 0: none
  int bins() const { return (outline_px > 0 ? 2 : 1) * angular_bins * radial_bins; }
  void check() const;
};

/// Shape contexts (III-B; Belongie, Malik and Puzicha 2002): for each point, the log-polar histogram of the
/// vectors to all the other points. Returns (N, angular·radial) counts, angle-major (angle * radial_bins +
/// radius); angle bin 0 starts at +u and turns towards +v. Radii are divided by the mean pairwise distance;
/// closer than inner_radius falls into the first ring, farther than outer_radius into none; the point itself
/// is not counted. gradients_rad (N) is needed only for relative_to_gradient, border_px (N) only for
/// outline_px: then (N, 2·angular·radial), the histogram of the vectors to all points before that of those
/// to points of the outline. Throws InvalidInput for non-finite numbers or a wrong number of gradients or
/// distances.
GRASPCTX_EXPORT FeatureMatrix shape_contexts(const std::vector<cv::Point2f>& points,
                                             const ShapeContextOptions& options = {},
                                             const std::vector<float>& gradients_rad = {},
                                             const std::vector<float>& border_px = {});

}  // namespace graspctx
