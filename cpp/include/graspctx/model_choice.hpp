#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "graspctx/export.hpp"
#include "graspctx/grasp_model.hpp"

namespace graspctx {

/// Keeps about 97 % of the objects that are as those of the training (Familiarity::at_distance).
inline constexpr double default_min_familiarity = 0.03;

/// The model that answers for an object, of several.
struct ModelChoice {
  std::size_t model = 0;   // its index
  double familiarity = 0;  // of the object to that model, 0 to 1
  bool familiar = false;   // the object is familiar enough to it
};

/// The vote: of the models that an object is familiar enough to, the one with the nearest training view; of
/// equals the first. If there is none, the one with the nearest training view of all, and `familiar` is
/// false. features: for each model the object's patch descriptors (M, D), by its own descriptor options.
/// Throws InvalidInput for no models, another number of features, a model without familiarity, or a
/// min_familiarity outside of 0 to 1.
GRASPCTX_EXPORT ModelChoice choose_model(const std::vector<const GraspModel*>& models,
                                         const std::vector<const FeatureMatrix*>& features,
                                         double min_familiarity);

}  // namespace graspctx
