#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "detail/image_name.hpp"
#include "detail/libsvm.hpp"
#include "detail/number_text.hpp"
#include "detail/random_draw.hpp"
#include "detail/sigmoid.hpp"
#include "graspctx/error.hpp"
#include "graspctx/evaluation.hpp"
#include "graspctx/grasp_model.hpp"
#include "graspctx/version.hpp"

namespace graspctx {

namespace {

void require(bool condition, const std::string& message) {
  if (!condition) throw InvalidInput("training: " + message);
}

/// All rows of one image.
struct Group {
  std::vector<int> rows;
  std::vector<int> drawn;  // rows the SVM is trained on: some of each class
  int positives = 0;
  int fold = 0;
  int rank = 0;  // in a random order, for the learning curve
};

struct Problem {
  const Eigen::Ref<const FeatureMatrix>& features;
  FeatureMatrix base_features;  // rows that follow those of features and are always trained on
  std::vector<int> labels;      // of both
  std::vector<int> base_rows;
  std::vector<Group> groups;
  int folds = 0;
};

/// What the base was taught, as far as it remembers: its support vectors, each with the sign it was given.
void add_base_rows(const GraspModel& base, Problem& problem) {
  const Eigen::ArrayXf mean = base.mean, scale = base.scale;
  problem.base_features =
      ((base.support_vectors.array().rowwise() * scale.transpose()).rowwise() + mean.transpose()).matrix();
  for (const double coefficient : base.coefficients) {
    problem.base_rows.push_back(static_cast<int>(problem.labels.size()));
    problem.labels.push_back(coefficient > 0 ? 1 : 0);
  }
}

Problem group_rows(const Eigen::Ref<const FeatureMatrix>& features, const std::vector<int>& labels,
                   const std::vector<int>& groups, const TrainOptions& options) {
  std::map<int, Group> by_id;  // sorted, so that nothing depends on the order of the images
  for (std::size_t row = 0; row < labels.size(); ++row) {
    Group& group = by_id[groups[row]];
    group.rows.push_back(static_cast<int>(row));
    group.positives += labels[row];
  }
  Problem problem{features, {}, labels, {}, {}, options.folds};
  if (options.base != nullptr) add_base_rows(*options.base, problem);
  for (auto& entry : by_id) problem.groups.push_back(std::move(entry.second));

  // Positives first throughout: the model does not depend on how the classes are mixed in the input.
  const auto positive = [&](int row) { return labels[static_cast<std::size_t>(row)] == 1; };
  for (Group& group : problem.groups) std::stable_partition(group.rows.begin(), group.rows.end(), positive);

  // Neighbouring patches are alike: a few of each image and class are enough, and bound the model's size.
  std::mt19937 random_rows(options.seed);
  const int fair_share = std::max(1, options.max_rows / (3 * static_cast<int>(problem.groups.size())));
  const int max_positives = std::min(options.max_positives_per_group, fair_share);
  const int max_negatives = std::min(options.max_negatives_per_group, 2 * fair_share);
  for (Group& group : problem.groups) {
    const auto first_negative = group.rows.begin() + group.positives;
    const auto draw = [&](std::vector<int> rows, int limit) {
      const auto kept = std::min<std::size_t>(limit, rows.size());
      detail::draw_to_front(rows, kept, random_rows);
      group.drawn.insert(group.drawn.end(), rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(kept));
    };
    draw({group.rows.begin(), first_negative}, max_positives);
    draw({first_negative, group.rows.end()}, max_negatives);
  }

  // Deal the groups to the folds. Those with both classes stand in the middle, so that the groups of each
  // class follow each other and two of them already reach two folds.
  std::vector<int> order[3];  // positives only, both, negatives only
  for (std::size_t i = 0; i < problem.groups.size(); ++i) {
    const Group& group = problem.groups[i];
    const bool all = group.positives == static_cast<int>(group.rows.size());
    order[all ? 0 : group.positives > 0 ? 1 : 2].push_back(static_cast<int>(i));
  }
  std::mt19937 random_folds(options.seed);  // its own: the folds do not depend on the number of negatives
  int dealt = 0;
  for (std::vector<int>& part : order) {
    detail::draw_to_front(part, part.size(), random_folds);
    for (const int group : part) problem.groups[group].fold = dealt++ % options.folds;
  }
  std::vector<int> ranked(problem.groups.size());
  std::iota(ranked.begin(), ranked.end(), 0);
  detail::draw_to_front(ranked, ranked.size(), random_folds);
  for (std::size_t i = 0; i < ranked.size(); ++i) problem.groups[ranked[i]].rank = static_cast<int>(i);
  return problem;
}

/// The rows of both classes are there to train on whichever fold is held out.
bool can_cross_validate(const Problem& problem, const std::vector<int>& chosen) {
  std::set<int> folds[2];
  for (const int index : chosen) {
    const Group& group = problem.groups[index];
    if (group.positives > 0) folds[1].insert(group.fold);
    if (group.positives < static_cast<int>(group.rows.size())) folds[0].insert(group.fold);
  }
  return folds[0].size() >= 2 && folds[1].size() >= 2;
}

/// Before anything takes long: none at all, or a name for each group that may stand in a model's file.
void check_image_names(const std::vector<int>& groups, const std::map<int, std::string>& names) {
  if (names.empty()) return;
  for (const int group : groups) {
    const auto found = names.find(group);
    require(found != names.end(), "image_names lacks group " + std::to_string(group));
    require(detail::is_image_name(found->second),
            "the name of image " + std::to_string(group) + " must be printable UTF-8 of 1 to " +
                std::to_string(detail::max_image_name_bytes) + " bytes, and relative");
  }
}

FeatureMatrix gather(const Problem& problem, const std::vector<int>& rows) {
  FeatureMatrix features(static_cast<Eigen::Index>(rows.size()), problem.features.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Eigen::Index row = rows[i], own = problem.features.rows();
    if (row < own) {
      features.row(i) = problem.features.row(row);
    } else {
      features.row(i) = problem.base_features.row(row - own);
    }
  }
  return features;
}

struct TrainedSvm {
  GraspModel model;       // the sigmoid is left open
  std::vector<int> rows;  // (S) the support vectors' rows of the problem
};

/// III-C: the SVM on the given rows and those of the base, all of it from these alone.
TrainedSvm train_svm(const Problem& problem, std::vector<int> rows, double svm_c, double gamma) {
  rows.insert(rows.end(), problem.base_rows.begin(), problem.base_rows.end());
  // Positives first, so that libsvm's order of the classes does not depend on the first row.
  std::stable_partition(rows.begin(), rows.end(), [&](int row) { return problem.labels[row] == 1; });
  FeatureMatrix features = gather(problem, rows);
  std::vector<int> labels;
  for (const int row : rows) labels.push_back(problem.labels[row]);

  GraspModel model;
  model.svm_c = svm_c;
  model.gamma = gamma;
  const Eigen::Index dimension = features.cols();
  model.mean.resize(dimension);
  model.scale.resize(dimension);
  for (Eigen::Index i = 0; i < dimension; ++i) {
    const Eigen::VectorXd column = features.col(i).cast<double>();
    const double mean = column.mean();
    const double stddev = std::sqrt((column.array() - mean).square().mean());
    model.mean[i] = static_cast<float>(mean);
    const bool constant = !(stddev > 1e-6 * std::abs(mean)) || static_cast<float>(stddev) < 1e-30f;
    model.scale[i] = constant ? 1.0f : static_cast<float>(stddev);
    features.col(i) =
        ((column.array() - static_cast<double>(model.mean[i])) / static_cast<double>(model.scale[i]))
            .cast<float>();
  }
  const detail::SvmSolution solution = detail::solve_c_svc(features, labels, svm_c, gamma);
  model.support_vectors.resize(static_cast<Eigen::Index>(solution.rows.size()), dimension);
  std::vector<int> support_rows;
  for (std::size_t i = 0; i < solution.rows.size(); ++i) {
    model.support_vectors.row(i) = features.row(solution.rows[i]);
    support_rows.push_back(rows[static_cast<std::size_t>(solution.rows[i])]);
  }
  model.coefficients = solution.coefficients;
  model.rho = solution.rho;
  return {std::move(model), std::move(support_rows)};
}

/// Keep which image each support vector comes from; images without one are left out. The vectors of a base
/// keep the names that it knows.
void name_images(GraspModel& model, const std::vector<int>& support_rows, const std::vector<int>& groups,
                 const TrainOptions& options) {
  std::map<std::string, int> index_of;
  for (const int row : support_rows) {
    const std::size_t own = groups.size(), at = static_cast<std::size_t>(row);
    std::string name;
    if (at < own) {
      name = options.image_names.at(groups[at]);
    } else if (options.base->support_images.empty()) {
      name = "base " + options.base->name;
    } else {
      name = options.base->training_images[static_cast<std::size_t>(options.base->support_images[at - own])];
    }
    const auto [entry, is_new] = index_of.try_emplace(name, static_cast<int>(model.training_images.size()));
    if (is_new) model.training_images.push_back(name);
    model.support_images.push_back(entry->second);
  }
}

/// Decision values of rows that their model has not seen.
struct HeldOut {
  std::vector<double> values;
  std::vector<int> labels;
  std::vector<int> rows, folds;  // where each value belongs
  int trained_images = 0;        // of all folds together
};

/// Of the groups outside a fold the first of a random order, until they are `share` of them and hold both
/// classes. All, if share is 1.
std::vector<int> groups_to_train(const Problem& problem, const std::vector<int>& chosen, int fold,
                                 double share) {
  std::vector<int> others;
  for (const int index : chosen) {
    if (problem.groups[index].fold != fold) others.push_back(index);
  }
  if (share >= 1) return others;
  std::sort(others.begin(), others.end(),
            [&](int a, int b) { return problem.groups[a].rank < problem.groups[b].rank; });
  const double wanted = std::max(1.0, std::round(share * static_cast<double>(others.size())));
  std::vector<int> taken;
  bool has[2] = {false, false};
  for (const int index : others) {
    if (static_cast<double>(taken.size()) >= wanted && has[0] && has[1]) break;
    const Group& group = problem.groups[index];
    has[1] |= group.positives > 0;
    has[0] |= group.positives < static_cast<int>(group.rows.size());
    taken.push_back(index);
  }
  std::sort(taken.begin(), taken.end());
  return taken;
}

/// Cross-validation over whole images (METHOD 5): trained on the drawn rows of the other folds, tested on
/// *all* rows of the fold, so that scores and sigmoid see the prior that a real image has.
template <typename AfterFold>
HeldOut hold_out(const Problem& problem, const std::vector<int>& chosen, double svm_c, double gamma,
                 const AfterFold& after_fold, double share = 1) {
  HeldOut held_out;
  for (int fold = 0; fold < problem.folds; ++fold) {
    std::vector<int> train, test;
    for (const int index : chosen) {
      const Group& group = problem.groups[index];
      if (group.fold == fold) test.insert(test.end(), group.rows.begin(), group.rows.end());
    }
    if (!test.empty()) {
      const std::vector<int> others = groups_to_train(problem, chosen, fold, share);
      for (const int index : others) {
        const std::vector<int>& drawn = problem.groups[index].drawn;
        train.insert(train.end(), drawn.begin(), drawn.end());
      }
      const GraspModel model = train_svm(problem, std::move(train), svm_c, gamma).model;
      const Eigen::VectorXd values = model.decision_values(gather(problem, test));
      held_out.values.insert(held_out.values.end(), values.begin(), values.end());
      for (const int row : test) held_out.labels.push_back(problem.labels[row]);
      held_out.rows.insert(held_out.rows.end(), test.begin(), test.end());
      held_out.folds.insert(held_out.folds.end(), test.size(), fold);
      held_out.trained_images += static_cast<int>(others.size());
    }
    after_fold();
  }
  return held_out;
}

int mean_images(const HeldOut& held_out, const Problem& problem) {
  return static_cast<int>(std::lround(static_cast<double>(held_out.trained_images) / problem.folds));
}

detail::Sigmoid fit_sigmoid(const std::vector<double>& values, const std::vector<int>& labels) {
  return detail::fit_sigmoid(
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())), labels);
}

/// P(g = 1 | D) in the order of the rows, each by a sigmoid that was fitted on the other folds: two numbers
/// fitted on a few images look better calibrated there than they are.
std::vector<double> held_out_probabilities(const HeldOut& held_out, int folds) {
  std::vector<double> probabilities(held_out.rows.size());
  for (int fold = 0; fold < folds; ++fold) {
    std::vector<double> values;
    std::vector<int> labels;
    for (std::size_t i = 0; i < held_out.rows.size(); ++i) {
      if (held_out.folds[i] == fold) continue;
      values.push_back(held_out.values[i]);
      labels.push_back(held_out.labels[i]);
    }
    if (values.size() == held_out.rows.size()) continue;  // an empty fold
    const detail::Sigmoid sigmoid = fit_sigmoid(values, labels);
    for (std::size_t i = 0; i < held_out.rows.size(); ++i) {
      if (held_out.folds[i] != fold) continue;
      probabilities[held_out.rows[i]] = detail::logistic(sigmoid.a * held_out.values[i] + sigmoid.b);
    }
  }
  return probabilities;
}

/// The groups for the search over C and γ: all, or as many drawn ones as fit.
std::vector<int> groups_for_search(const Problem& problem, const TrainOptions& options) {
  std::vector<int> all(problem.groups.size());
  std::size_t rows = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = static_cast<int>(i);
    rows += problem.groups[i].drawn.size();
  }
  const auto limit = static_cast<std::size_t>(options.max_search_rows);
  if (rows <= limit) return all;
  std::vector<int> order = all, chosen;
  std::mt19937 random(options.seed);
  detail::draw_to_front(order, order.size(), random);
  rows = 0;
  for (const int index : order) {
    rows += problem.groups[index].drawn.size();
    if (rows > limit) break;
    chosen.push_back(index);
  }
  std::sort(chosen.begin(), chosen.end());
  return can_cross_validate(problem, chosen) ? chosen : all;
}

}  // namespace

void TrainOptions::check() const {
  const auto all_positive = [](const std::vector<double>& values) {
    return !values.empty() &&
           std::all_of(values.begin(), values.end(), [](double v) { return v > 0 && v <= 1e6; });
  };
  require(all_positive(svm_c), "svm_c must hold values over 0, at most 1e6");
  require(all_positive(gamma_times_dimension), "gamma_times_dimension must hold values over 0, at most 1e6");
  require(folds >= 2 && folds <= 1000, "folds must lie between 2 and 1000, got " + std::to_string(folds));
  require(max_positives_per_group >= 1,
          "max_positives_per_group must be at least 1, got " + std::to_string(max_positives_per_group));
  require(max_negatives_per_group >= 1,
          "max_negatives_per_group must be at least 1, got " + std::to_string(max_negatives_per_group));
  require(max_rows >= 10, "max_rows must be at least 10, got " + std::to_string(max_rows));
  require(max_search_rows >= 1, "max_search_rows must be at least 1, got " + std::to_string(max_search_rows));
  require(std::all_of(learning_curve.begin(), learning_curve.end(), [](double s) { return s > 0 && s < 1; }),
          "learning_curve must hold shares over 0 and under 1");
}

TrainOptions warm_start(const GraspModel& base) {
  TrainOptions options;
  options.base = &base;
  options.svm_c = {base.svm_c};
  options.gamma_times_dimension = {base.gamma * static_cast<double>(base.mean.size())};
  // The few images there are have to hold their own against thousands of support vectors: more patches of
  // each count, up to a number of rows that keeps the training short.
  options.max_positives_per_group = 60;
  options.max_negatives_per_group = 120;
  options.max_rows = 3600;
  return options;
}

GraspModel train_model(const Eigen::Ref<const FeatureMatrix>& features, const std::vector<int>& labels,
                       const std::vector<int>& groups, const TrainOptions& options) {
  return train_and_validate(features, labels, groups, options).model;
}

Training train_and_validate(const Eigen::Ref<const FeatureMatrix>& features, const std::vector<int>& labels,
                            const std::vector<int>& groups, const TrainOptions& options) {
  options.check();
  const auto count = static_cast<std::size_t>(features.rows());
  require(labels.size() == count && groups.size() == count,
          "expected one label and one group for each of the " + std::to_string(count) + " rows, got " +
              std::to_string(labels.size()) + " and " + std::to_string(groups.size()));
  require(features.cols() >= 1, "the features must have at least one column");
  require(count <= static_cast<std::size_t>(std::numeric_limits<int>::max()), "too many rows");
  for (const int label : labels) {
    require(label == 0 || label == 1, "labels must be 0 or 1, got " + std::to_string(label));
  }
  const auto positives = std::count(labels.begin(), labels.end(), 1);
  require(positives > 0 && positives < static_cast<std::ptrdiff_t>(count),
          "both classes are needed, got " + std::to_string(positives) + " positive of " +
              std::to_string(count) + " rows");
  require(features.allFinite(), "all features must be finite");
  check_image_names(groups, options.image_names);
  if (options.base != nullptr) {
    require(options.base->mean.size() == features.cols(),
            "the base takes " + std::to_string(options.base->mean.size()) + " features, the rows have " +
                std::to_string(features.cols()));
    options.base->decision_values(features.topRows(0));  // throws unless its numbers are sound
  }

  const Problem problem = group_rows(features, labels, groups, options);
  require(problem.groups.size() >= static_cast<std::size_t>(options.folds),
          "fewer groups (" + std::to_string(problem.groups.size()) + ") than folds (" +
              std::to_string(options.folds) + ")");
  std::vector<int> all(problem.groups.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  require(can_cross_validate(problem, all), "each class must occur in at least two groups");

  const auto candidates = options.svm_c.size() * options.gamma_times_dimension.size();
  const double steps = static_cast<double>(
      (candidates + 1 + options.learning_curve.size()) * static_cast<std::size_t>(options.folds) + 1);
  double done = 0;
  const auto advance = [&](const std::string& what) {
    ++done;
    if (options.progress) options.progress(done / steps, what);
  };

  // C and γ by the average precision on held-out images. Of equals the first, with the smaller C and γ in
  // the default order: the smoother model.
  const std::vector<int> searched = groups_for_search(problem, options);
  const double dimension = static_cast<double>(features.cols());
  double best_c = options.svm_c.front(), best_relative_gamma = options.gamma_times_dimension.front();
  double best_score = -1;
  HeldOut held_out;
  if (candidates > 1) {
    std::size_t candidate = 0;
    for (const double svm_c : options.svm_c) {
      for (const double relative_gamma : options.gamma_times_dimension) {
        const std::string what = "cross-validation of C and gamma, " + std::to_string(++candidate) + " of " +
                                 std::to_string(candidates);
        const double gamma = relative_gamma / dimension;
        HeldOut result = hold_out(problem, searched, svm_c, gamma, [&] { advance(what); });
        const double score = average_precision(result.values, result.labels);
        if (score > best_score) {
          best_score = score;
          best_c = svm_c;
          best_relative_gamma = relative_gamma;
          held_out = std::move(result);
        }
      }
    }
  } else {
    done += options.folds;
  }

  const double best_gamma = best_relative_gamma / dimension;

  // Platt's sigmoid on held-out images with all their patches.
  if (candidates > 1 && searched.size() == problem.groups.size()) {
    done += options.folds - 1;
    advance("sigmoid");  // the search has already held out every image
  } else {
    held_out = hold_out(problem, all, best_c, best_gamma, [&] { advance("sigmoid on held-out images"); });
  }
  const detail::Sigmoid sigmoid = fit_sigmoid(held_out.values, held_out.labels);
  std::vector<double> probabilities;
  for (const double value : held_out.values) {
    probabilities.push_back(detail::logistic(sigmoid.a * value + sigmoid.b));
  }

  Training training;
  training.held_out_probabilities = held_out_probabilities(held_out, options.folds);
  training.images_of_folds = mean_images(held_out, problem);
  for (const double share : options.learning_curve) {
    const HeldOut step = hold_out(
        problem, all, best_c, best_gamma, [&] { advance("learning curve"); }, share);
    training.learning_curve.push_back(
        {mean_images(step, problem), held_out_probabilities(step, options.folds)});
  }

  // The final model on everything.
  std::vector<int> rows;
  for (const Group& group : problem.groups) rows.insert(rows.end(), group.drawn.begin(), group.drawn.end());
  const std::size_t rows_used = rows.size();
  TrainedSvm trained = train_svm(problem, std::move(rows), best_c, best_gamma);
  GraspModel& model = trained.model;
  if (!options.image_names.empty()) name_images(model, trained.rows, groups, options);
  model.sigmoid_a = sigmoid.a;
  model.sigmoid_b = sigmoid.b;
  model.provenance = {
      {"graspctx", version},
      {"libsvm", detail::libsvm_version_text()},
      {"training.rows", std::to_string(count)},
      {"training.positives", std::to_string(positives)},
      {"training.groups", std::to_string(problem.groups.size())},
      {"training.rows_of_svm", std::to_string(rows_used)},
      {"training.support_vectors", std::to_string(model.coefficients.size())},
      {"training.max_rows", std::to_string(options.max_rows)},
      {"training.max_positives_per_group", std::to_string(options.max_positives_per_group)},
      {"training.max_negatives_per_group", std::to_string(options.max_negatives_per_group)},
      {"training.seed", std::to_string(options.seed)},
      {"training.c", detail::number_text(best_c)},
      {"training.gamma_times_dimension", detail::number_text(best_relative_gamma)},
      {"cross_validation.folds", std::to_string(options.folds)},
      {"cross_validation.average_precision",
       detail::number_text(average_precision(held_out.values, held_out.labels))},
      {"cross_validation.roc_area", detail::number_text(roc_area(held_out.values, held_out.labels))},
      {"cross_validation.calibration_error",
       detail::number_text(expected_calibration_error(probabilities, held_out.labels))},
  };
  if (options.base != nullptr) {
    model.provenance["training.base_rows"] = std::to_string(problem.base_rows.size());
  }
  advance("final model");
  training.model = std::move(model);
  return training;
}

}  // namespace graspctx
