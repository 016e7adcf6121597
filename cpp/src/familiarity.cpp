#include "graspctx/familiarity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>

#include "detail/random_draw.hpp"
#include "graspctx/error.hpp"

namespace graspctx {

namespace {

void require(bool condition, const std::string& message) {
  if (!condition) throw InvalidInput("familiarity: " + message);
}

Eigen::RowVectorXd mean_row(const Eigen::Ref<const FeatureMatrix>& features) {
  return features.cast<double>().colwise().mean();
}

struct TrainingView {
  int group = 0;
  std::vector<int> rows;
};

std::vector<TrainingView> training_views(const std::vector<int>& views, const std::vector<int>& groups) {
  std::map<int, TrainingView> by_id;  // sorted, so that nothing depends on the order of the rows
  for (std::size_t row = 0; row < views.size(); ++row) {
    TrainingView& view = by_id[views[row]];
    if (view.rows.empty()) view.group = groups[row];
    require(view.group == groups[row], "view " + std::to_string(views[row]) + " is in two groups");
    view.rows.push_back(static_cast<int>(row));
  }
  std::vector<TrainingView> result;
  for (auto& entry : by_id) result.push_back(std::move(entry.second));
  return result;
}

/// All views, or as many drawn ones as are wanted, in their order.
std::vector<TrainingView> drawn_views(const std::vector<TrainingView>& all,
                                      const FamiliarityOptions& options) {
  std::vector<int> order(all.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  const std::size_t count = std::min(all.size(), static_cast<std::size_t>(options.max_views));
  std::mt19937 random(options.seed);
  if (count < all.size()) detail::draw_to_front(order, count, random);
  order.resize(count);
  std::sort(order.begin(), order.end());
  std::vector<TrainingView> drawn;
  for (const int index : order) drawn.push_back(all[static_cast<std::size_t>(index)]);
  return drawn;
}

}  // namespace

void Familiarity::check() const {
  require(views.rows() >= 2 && views.cols() >= 1,
          "expected the descriptors of two training views or more, got " + std::to_string(views.rows()));
  require(held_out_distances.size() == views.rows(),
          "it has " + std::to_string(views.rows()) + " training views, but " +
              std::to_string(held_out_distances.size()) + " distances");
  // Descriptors are square roots of shares: values far beyond 1 would be none, and could overflow.
  require(views.allFinite() && (views.array().abs() <= 1e9f).all(),
          "the descriptors of the training views must be finite and at most 1e9");
  double last = 0;
  for (const double distance : held_out_distances) {
    require(distance >= last && distance <= 1e15,
            "the held-out distances must be ascending, from 0 to 1e15");  // not for NaN
    last = distance;
  }
}

double Familiarity::distance(const Eigen::Ref<const FeatureMatrix>& features) const {
  check();
  require(features.cols() == views.cols(), "the training views have " + std::to_string(views.cols()) +
                                               " columns, the features " + std::to_string(features.cols()));
  require(features.rows() > 0, "expected the descriptors of one patch or more, got none");
  require(features.allFinite(), "all features must be finite");
  const Eigen::RowVectorXd object = mean_row(features);
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < views.rows(); ++i) {
    nearest = std::min(nearest, (views.row(i).cast<double>() - object).squaredNorm());
  }
  return std::sqrt(nearest);
}

double Familiarity::at_distance(double distance) const {
  check();
  const auto* end = held_out_distances.data() + held_out_distances.size();
  const auto as_far = end - std::lower_bound(held_out_distances.data(), end, distance);
  return (1 + static_cast<double>(as_far)) / (1 + static_cast<double>(held_out_distances.size()));
}

void FamiliarityOptions::check() const {
  require(max_views >= 2 && max_views <= 100000,
          "max_views must lie between 2 and 100000, got " + std::to_string(max_views));
}

Familiarity learn_familiarity(const Eigen::Ref<const FeatureMatrix>& features, const std::vector<int>& views,
                              const std::vector<int>& groups, const FamiliarityOptions& options) {
  options.check();
  const auto count = static_cast<std::size_t>(features.rows());
  require(views.size() == count && groups.size() == count,
          "expected one view and one group for each of the " + std::to_string(count) + " rows, got " +
              std::to_string(views.size()) + " and " + std::to_string(groups.size()));
  require(features.cols() >= 1, "the features must have at least one column");
  require(features.allFinite(), "all features must be finite");
  const std::vector<TrainingView> drawn = drawn_views(training_views(views, groups), options);
  const bool several = std::any_of(drawn.begin(), drawn.end(), [&](const TrainingView& view) {
    return view.group != drawn.front().group;
  });
  require(several, "expected views of two groups or more");

  Familiarity learnt;
  const auto size = static_cast<Eigen::Index>(drawn.size());
  learnt.views.resize(size, features.cols());
  for (Eigen::Index i = 0; i < size; ++i) {
    const std::vector<int>& rows = drawn[static_cast<std::size_t>(i)].rows;
    FeatureMatrix patches(static_cast<Eigen::Index>(rows.size()), features.cols());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      patches.row(static_cast<Eigen::Index>(k)) = features.row(rows[k]);
    }
    learnt.views.row(i) = mean_row(patches).cast<float>();
  }

  // Each view as if its image were new: how far is the nearest of the other images?
  constexpr double none = std::numeric_limits<double>::infinity();
  Eigen::VectorXd nearest = Eigen::VectorXd::Constant(size, none);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index k = 0; k < i; ++k) {
      if (drawn[static_cast<std::size_t>(i)].group == drawn[static_cast<std::size_t>(k)].group) continue;
      const double squared =
          (learnt.views.row(i).cast<double>() - learnt.views.row(k).cast<double>()).squaredNorm();
      nearest[i] = std::min(nearest[i], squared);
      nearest[k] = std::min(nearest[k], squared);
    }
  }
  std::sort(nearest.data(), nearest.data() + size);
  learnt.held_out_distances = nearest.cwiseSqrt();
  learnt.check();
  return learnt;
}

}  // namespace graspctx
