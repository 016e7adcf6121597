#include "graspctx/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detail/border_patch.hpp"
#include "detail/patch_measures.hpp"
#include "graspctx/error.hpp"

namespace graspctx {

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double large_label_share = 0.02;  // of the object

void check_scores(const std::vector<double>& scores, const std::vector<int>& labels) {
  if (scores.size() != labels.size()) {
    throw InvalidInput("evaluation: got " + std::to_string(scores.size()) + " scores, but " +
                       std::to_string(labels.size()) + " labels");
  }
  for (const double score : scores) {
    if (std::isnan(score)) throw InvalidInput("evaluation: a score is not a number");
  }
  for (const int label : labels) {
    if (label != 0 && label != 1) {
      throw InvalidInput("evaluation: labels must be 0 or 1, got " + std::to_string(label));
    }
  }
}

/// What is gathered over the views of one class.
struct Tally {
  std::vector<double> probabilities, probabilities_inner;
  std::vector<int> labels, labels_inner;  // inner: without patches of which less than half is labelled
  int views = 0, views_without_label = 0, hits = 0, views_large = 0, hits_large = 0;
  double chance = 0;

  void add(const ScoredView& view) {
    const std::vector<double>& p = view.probabilities;
    double positives = 0;
    std::size_t best = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      probabilities.push_back(p[i]);
      labels.push_back(view.labels[i]);
      if (!detail::is_border_patch(view.labels[i], view.label_share[i])) {
        probabilities_inner.push_back(p[i]);
        labels_inner.push_back(view.labels[i]);
      }
      positives += view.labels[i];
      if (p[i] > p[best]) best = i;
    }
    if (positives == 0) {
      ++views_without_label;
      return;
    }
    const int hit = view.labels[best];
    ++views;
    hits += hit;
    chance += positives / static_cast<double>(p.size());
    if (view.visible_label_share > large_label_share) {
      ++views_large;
      hits_large += hit;
    }
  }

  void add(const Tally& other) {
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(probabilities, other.probabilities);
    append(probabilities_inner, other.probabilities_inner);
    append(labels, other.labels);
    append(labels_inner, other.labels_inner);
    views += other.views;
    views_without_label += other.views_without_label;
    hits += other.hits;
    views_large += other.views_large;
    hits_large += other.hits_large;
    chance += other.chance;
  }

  ClassEvaluation evaluate(const std::string& class_name) const {
    const auto share = [](double part, double whole) { return whole > 0 ? part / whole : nothing; };
    ClassEvaluation row;
    row.class_name = class_name;
    row.views = views;
    row.views_without_label = views_without_label;
    row.patches = static_cast<int>(labels.size());
    row.label_prior = share(static_cast<double>(std::count(labels.begin(), labels.end(), 1)),
                            static_cast<double>(labels.size()));
    row.average_precision = graspctx::average_precision(probabilities, labels);
    row.average_precision_border_ignored = graspctx::average_precision(probabilities_inner, labels_inner);
    row.roc_area = graspctx::roc_area(probabilities, labels);
    row.calibration_error = expected_calibration_error(probabilities, labels);
    row.top1 = share(hits, views);
    row.top1_interval = wilson_interval(hits, views);
    row.top1_chance = share(chance, views);
    row.top1_large_label = share(hits_large, views_large);
    row.views_large_label = views_large;
    return row;
  }
};

}  // namespace

double average_precision(const std::vector<double>& scores, const std::vector<int>& labels) {
  check_scores(scores, labels);
  return detail::average_precision(detail::highest_first(detail::scored_patches(scores, labels)), {1});
}

double roc_area(const std::vector<double>& scores, const std::vector<int>& labels) {
  check_scores(scores, labels);
  return detail::roc_area(detail::highest_first(detail::scored_patches(scores, labels)), {1});
}

double expected_calibration_error(const std::vector<double>& probabilities, const std::vector<int>& labels,
                                  int bins) {
  check_scores(probabilities, labels);
  if (bins < 1 || bins > 1000000) {
    throw InvalidInput("evaluation: expected at least one bin, got " + std::to_string(bins));
  }
  for (const double p : probabilities) {
    if (p < 0 || p > 1) throw InvalidInput("evaluation: a probability lies outside 0 to 1");
  }
  return detail::calibration_error(detail::scored_patches(probabilities, labels), {1}, bins);
}

Interval wilson_interval(int successes, int trials) {
  if (successes < 0 || successes > trials) {
    throw InvalidInput("evaluation: expected 0 to " + std::to_string(trials) + " successes, got " +
                       std::to_string(successes));
  }
  if (trials == 0) return {};
  const double z = 1.959963984540054;  // 97.5 % quantile of the normal distribution
  const double n = trials, share = successes / n, z2 = z * z;
  const double centre = (share + z2 / (2 * n)) / (1 + z2 / n);
  const double half = z / (1 + z2 / n) * std::sqrt(share * (1 - share) / n + z2 / (4 * n * n));
  return {successes == 0 ? 0 : centre - half, successes == trials ? 1 : centre + half};
}

std::vector<ScoredView> score_views(const GraspModel& model, const std::vector<LabelledView>& views) {
  std::vector<ScoredView> scored;
  for (const LabelledView& view : views) {
    LabelledPatches described = describe_labelled_view(view, model.descriptor);
    const Eigen::VectorXd p = model.predict_probability(described.patches.features);
    scored.push_back({view.source,
                      view.class_name,
                      view.group,
                      described.visible_label_share,
                      std::move(described.labels),
                      std::move(described.label_share),
                      {p.begin(), p.end()}});
  }
  return scored;
}

std::vector<ScoredView> held_out_views(const std::vector<LabelledView>& views, const TrainingSet& set,
                                       const std::vector<double>& probabilities) {
  const std::size_t rows = set.labels.size();
  if (set.true_views.size() != rows || set.label_share.size() != rows || probabilities.size() != rows) {
    throw InvalidInput("evaluation: expected the rows that were trained on, got " + std::to_string(rows) +
                       " labels and " + std::to_string(probabilities.size()) + " held-out answers");
  }
  std::vector<ScoredView> scored;
  for (const LabelledView& view : views) {
    scored.push_back({view.source, view.class_name, view.group, visible_label_share(view), {}, {}, {}});
  }
  for (std::size_t row = 0; row < rows; ++row) {
    if (set.true_views[row] < 0) continue;
    ScoredView& view = scored.at(set.true_views[row]);
    view.labels.push_back(set.labels[row]);
    view.label_share.push_back(set.label_share[row]);
    view.probabilities.push_back(probabilities[row]);
  }
  return scored;
}

std::vector<ClassEvaluation> evaluate_scores(const std::vector<ScoredView>& views) {
  std::vector<std::string> names;  // in the order of first appearance
  std::vector<Tally> tallies;
  for (const ScoredView& view : views) {
    const auto found = std::find(names.begin(), names.end(), view.class_name);
    const std::size_t index = static_cast<std::size_t>(found - names.begin());
    if (found == names.end()) {
      names.push_back(view.class_name);
      tallies.emplace_back();
    }
    tallies[index].add(view);
  }
  std::vector<ClassEvaluation> rows;
  for (std::size_t i = 0; i < names.size(); ++i) rows.push_back(tallies[i].evaluate(names[i]));
  if (names.size() > 1) {
    Tally all;
    for (const Tally& tally : tallies) all.add(tally);
    rows.push_back(all.evaluate("all"));
  }
  return rows;
}

std::vector<ClassEvaluation> evaluate_model(const GraspModel& model, const std::vector<LabelledView>& views) {
  return evaluate_scores(score_views(model, views));
}

}  // namespace graspctx
