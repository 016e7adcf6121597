#include "graspctx/model_choice.hpp"

#include <utility>

#include "graspctx/error.hpp"

namespace graspctx {

ModelChoice choose_model(const std::vector<const GraspModel*>& models,
                         const std::vector<const FeatureMatrix*>& features, double min_familiarity) {
  if (models.empty()) throw InvalidInput("models: expected one or more, got none");
  if (features.size() != models.size()) {
    throw InvalidInput("models: expected features for each of the " + std::to_string(models.size()) +
                       ", got " + std::to_string(features.size()));
  }
  if (!(min_familiarity >= 0 && min_familiarity <= 1)) {
    throw InvalidInput("options: min_familiarity must be 0 to 1");
  }
  ModelChoice best;
  double nearest = 0;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const GraspModel& model = *models[i];
    if (!model.familiarity) {
      throw InvalidInput("model '" + model.name +
                         "' cannot tell what is familiar: expected one that was trained with familiarity");
    }
    const double distance = model.familiarity->distance(*features[i]);
    ModelChoice choice{i, model.familiarity->at_distance(distance), false};
    choice.familiar = choice.familiarity >= min_familiarity;
    if (i == 0 || std::pair(choice.familiar, -distance) > std::pair(best.familiar, -nearest)) {
      best = choice;
      nearest = distance;
    }
  }
  return best;
}

}  // namespace graspctx
