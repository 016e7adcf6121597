#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "graspctx/evaluation.hpp"

namespace graspctx::detail {

struct ScoredPatch {
  double score = 0;
  int label = 0;  // 0 or 1
  int image = 0;  // 0, 1, …
};
using ScoredPatches = std::vector<ScoredPatch>;

/// Every patch, as of one image.
ScoredPatches scored_patches(const std::vector<double>& scores, const std::vector<int>& labels);
ScoredPatches highest_first(ScoredPatches patches);

/// Measures of patches that count as often as their image's weight says, once each with one weight of 1; NaN
/// where they are not defined. Those of ranked patches take the highest score first.
using Weights = std::vector<int>;  // by image
double average_precision(const ScoredPatches& ranked, const Weights& weights);
double roc_area(const ScoredPatches& ranked, const Weights& weights);
double calibration_error(const ScoredPatches& patches, const Weights& weights, int bins);

/// 95 % interval of a measure over images drawn with replacement (the bootstrap's percentiles): patches of
/// one image are alike, so it is images that are drawn. NaN if fewer than two draws define the measure.
Interval resampled_interval(int images, const std::function<double(const Weights&)>& measure, int resamples,
                            std::uint32_t seed);

}  // namespace graspctx::detail
