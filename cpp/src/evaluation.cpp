#include "graspctx/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "graspctx/error.hpp"

namespace graspctx {

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double large_label_share = 0.02;  // of the object
constexpr double border_share = 0.5;        // of a patch

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

std::vector<std::size_t> highest_first(const std::vector<double>& scores) {
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  return order;
}

/// Calls visit(positives, negatives) for each group of equal scores, the highest first.
template <typename Visit>
void for_each_tie(const std::vector<double>& scores, const std::vector<int>& labels, const Visit& visit) {
  const std::vector<std::size_t> order = highest_first(scores);
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first;
    double positives = 0;
    for (; last < order.size() && scores[order[last]] == scores[order[first]]; ++last) {
      positives += labels[order[last]];
    }
    visit(positives, static_cast<double>(last - first) - positives);
    first = last;
  }
}

/// What is gathered over the views of one class.
struct Tally {
  std::vector<double> probabilities, probabilities_inner;
  std::vector<int> labels, labels_inner;  // inner: without patches of which less than half is labelled
  int views = 0, views_without_label = 0, hits = 0, views_large = 0, hits_large = 0;
  double chance = 0;

  void add(const LabelledPatches& described, const Eigen::VectorXd& p) {
    double positives = 0;
    Eigen::Index best = 0;
    for (Eigen::Index i = 0; i < p.size(); ++i) {
      probabilities.push_back(p[i]);
      labels.push_back(described.labels[i]);
      if (described.labels[i] == 0 || described.label_share[i] >= border_share) {
        probabilities_inner.push_back(p[i]);
        labels_inner.push_back(described.labels[i]);
      }
      positives += described.labels[i];
      if (p[i] > p[best]) best = i;
    }
    if (positives == 0) {
      ++views_without_label;
      return;
    }
    const int hit = described.labels[best];
    ++views;
    hits += hit;
    chance += positives / static_cast<double>(p.size());
    if (described.visible_label_share > large_label_share) {
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
  double area = 0, found = 0, taken = 0;
  for_each_tie(scores, labels, [&](double positives, double negatives) {
    found += positives;
    taken += positives + negatives;
    area += positives * found / taken;  // a step in recall times the precision reached there
  });
  return found > 0 ? area / found : nothing;
}

double roc_area(const std::vector<double>& scores, const std::vector<int>& labels) {
  check_scores(scores, labels);
  double pairs_in_order = 0, positives_above = 0, negatives_all = 0;
  for_each_tie(scores, labels, [&](double positives, double negatives) {
    pairs_in_order += negatives * (positives_above + positives / 2);
    positives_above += positives;
    negatives_all += negatives;
  });
  const double pairs = positives_above * negatives_all;
  return pairs > 0 ? pairs_in_order / pairs : nothing;
}

double expected_calibration_error(const std::vector<double>& probabilities, const std::vector<int>& labels,
                                  int bins) {
  check_scores(probabilities, labels);
  if (bins < 1 || bins > 1000000) {
    throw InvalidInput("evaluation: expected at least one bin, got " + std::to_string(bins));
  }
  std::vector<double> excess(bins, 0.0);  // Σ (P − label) of the bin
  for (std::size_t i = 0; i < probabilities.size(); ++i) {
    const double p = probabilities[i];
    if (p < 0 || p > 1) throw InvalidInput("evaluation: a probability lies outside 0 to 1");
    const int bin = std::min(static_cast<int>(p * bins), bins - 1);  // 1 belongs to the last bin
    excess[bin] += p - labels[i];
  }
  double error = 0;
  for (const double value : excess) error += std::abs(value);
  return probabilities.empty() ? nothing : error / static_cast<double>(probabilities.size());
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

std::vector<ClassEvaluation> evaluate_model(const GraspModel& model, const std::vector<LabelledView>& views) {
  std::vector<std::string> names;  // in the order of first appearance
  std::vector<Tally> tallies;
  for (const LabelledView& view : views) {
    const auto found = std::find(names.begin(), names.end(), view.class_name);
    const std::size_t index = static_cast<std::size_t>(found - names.begin());
    if (found == names.end()) {
      names.push_back(view.class_name);
      tallies.emplace_back();
    }
    const LabelledPatches described = describe_labelled_view(view, model.descriptor);
    tallies[index].add(described, model.predict_probability(described.patches.features));
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

}  // namespace graspctx
