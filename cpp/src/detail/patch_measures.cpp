#include "detail/patch_measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detail/quantile.hpp"
#include "detail/random_draw.hpp"

namespace graspctx::detail {

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

/// Calls visit(positives, negatives) for each group of equal scores, the highest first.
template <typename Visit>
void for_each_tie(const ScoredPatches& ranked, const Weights& weights, const Visit& visit) {
  for (std::size_t first = 0; first < ranked.size();) {
    std::size_t last = first;
    double of_class[2] = {0, 0};
    for (; last < ranked.size() && ranked[last].score == ranked[first].score; ++last) {
      of_class[ranked[last].label] += weights[ranked[last].image];
    }
    visit(of_class[1], of_class[0]);
    first = last;
  }
}

}  // namespace

ScoredPatches scored_patches(const std::vector<double>& scores, const std::vector<int>& labels) {
  ScoredPatches patches(scores.size());
  for (std::size_t i = 0; i < scores.size(); ++i) patches[i] = {scores[i], labels[i], 0};
  return patches;
}

ScoredPatches highest_first(ScoredPatches patches) {
  std::stable_sort(patches.begin(), patches.end(),
                   [](const ScoredPatch& a, const ScoredPatch& b) { return a.score > b.score; });
  return patches;
}

double average_precision(const ScoredPatches& ranked, const Weights& weights) {
  double area = 0, found = 0, taken = 0;
  for_each_tie(ranked, weights, [&](double positives, double negatives) {
    found += positives;
    taken += positives + negatives;
    if (positives > 0) area += positives * found / taken;  // a step in recall times the precision there
  });
  return found > 0 ? area / found : nothing;
}

double roc_area(const ScoredPatches& ranked, const Weights& weights) {
  double pairs_in_order = 0, positives_above = 0, negatives_all = 0;
  for_each_tie(ranked, weights, [&](double positives, double negatives) {
    pairs_in_order += negatives * (positives_above + positives / 2);
    positives_above += positives;
    negatives_all += negatives;
  });
  const double pairs = positives_above * negatives_all;
  return pairs > 0 ? pairs_in_order / pairs : nothing;
}

double calibration_error(const ScoredPatches& patches, const Weights& weights, int bins) {
  std::vector<double> excess(bins, 0.0);  // Σ (P − label) of the bin
  double count = 0;
  for (const ScoredPatch& patch : patches) {
    const double weight = weights[patch.image];
    const int bin = std::min(static_cast<int>(patch.score * bins), bins - 1);  // 1 belongs to the last bin
    excess[bin] += weight * (patch.score - patch.label);
    count += weight;
  }
  double error = 0;
  for (const double value : excess) error += std::abs(value);
  return count > 0 ? error / count : nothing;
}

Interval resampled_interval(int images, const std::function<double(const Weights&)>& measure, int resamples,
                            std::uint32_t seed) {
  std::vector<double> values;
  std::mt19937 random(seed);
  for (int i = 0; i < resamples; ++i) {
    Weights weights(images, 0);
    for (int n = 0; n < images; ++n) ++weights[draw_below(random, static_cast<std::uint32_t>(images))];
    const double value = measure(weights);
    if (!std::isnan(value)) values.push_back(value);
  }
  if (values.size() < 2) return {nothing, nothing};
  return {quantile(values, 0.025), quantile(values, 0.975)};
}

}  // namespace graspctx::detail
