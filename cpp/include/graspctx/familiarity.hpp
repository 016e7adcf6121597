#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "graspctx/export.hpp"
#include "graspctx/shape_context.hpp"

namespace graspctx {

/// How much an object looks like what a model was taught: the whole object as one descriptor, compared with
/// those of the training views. It tells shapes apart, not grasping points.
struct GRASPCTX_EXPORT Familiarity {
  FeatureMatrix views;  // (V, D) the mean patch descriptor of each training view
  /// (V) ascending: from each view to the nearest one of another image, as an object never seen has it.
  Eigen::VectorXd held_out_distances;

  /// Throws InvalidInput unless sizes agree and all numbers are finite and in range.
  void check() const;
  /// To the nearest training view, from an object of these patch descriptors (M, D), M > 0. Throws
  /// InvalidInput for another width, no rows or non-finite values.
  double distance(const Eigen::Ref<const FeatureMatrix>& features) const;
  /// 0 to 1: the share of the training views that are as far from the others as that, the object itself
  /// counted among them. Of objects as those of the training a share p has a familiarity of p or less (a
  /// conformal p-value).
  double at_distance(double distance) const;
};

struct GRASPCTX_EXPORT FamiliarityOptions {
  int max_views = 500;  // of all training views; more are drawn from
  std::uint32_t seed = 1;
  void check() const;
};

/// Learn what is familiar from the training rows alone. features (R, D); views, groups (R): the view and the
/// image that each row comes from; views of one image are never compared with each other. Throws InvalidInput
/// for sizes that differ, non-finite features, a view in two groups, or fewer than two groups.
GRASPCTX_EXPORT Familiarity learn_familiarity(const Eigen::Ref<const FeatureMatrix>& features,
                                              const std::vector<int>& views, const std::vector<int>& groups,
                                              const FamiliarityOptions& options = {});

}  // namespace graspctx
