#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "graspctx/export.hpp"
#include "graspctx/patch_descriptor.hpp"

namespace graspctx {

struct GRASPCTX_EXPORT GraspPointOptions {
  int max_points = 10;
  double neighbour_ratio = 0.5;  // mean of the classified neighbours, as a share of the centre's value
  void check() const;
};

/// A local maximum of the response in one view.
struct GraspPoint {
  int patch = 0;           // row in the PatchDescriptors
  cv::Point2f centre_px;   // of the view
  double probability = 0;  // P(g = 1 | D) in this view
};

/// Patches that are local maxima of the response and whose 8 neighbours carry values close to the centre's;
/// the highest first, ties by row and column (III-D, IV). probabilities (M) belong to the descriptors' rows.
GRASPCTX_EXPORT std::vector<GraspPoint> find_grasp_points(const PatchDescriptors& patches,
                                                          const Eigen::VectorXd& probabilities,
                                                          const GraspPointOptions& options = {});

}  // namespace graspctx
