#include "graspctx/evaluation_report.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "detail/border_patch.hpp"
#include "detail/check.hpp"
#include "detail/patch_measures.hpp"

namespace graspctx {

namespace {

using detail::ScoredPatch;
using detail::ScoredPatches;
using detail::Weights;

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double label_share_limits[] = {0, 0.02, 0.05, 0.1, 0.2, 1};

double share_of(double part, double whole) {
  return whole > 0 ? part / whole : nothing;
}

/// Numbers of the images 0, 1, … by their groups, whatever those are.
std::map<int, int> number_images(const std::vector<ScoredView>& views) {
  std::map<int, int> numbers;
  for (const ScoredView& view : views) numbers[view.group] = 0;
  int next = 0;
  for (auto& entry : numbers) entry.second = next++;
  return numbers;
}

ScoredPatches patches_of(const std::vector<ScoredView>& views, bool border_ignored = false) {
  const std::map<int, int> image_of = number_images(views);
  ScoredPatches patches;
  for (const ScoredView& view : views) {
    for (std::size_t i = 0; i < view.labels.size(); ++i) {
      if (border_ignored && detail::is_border_patch(view.labels[i], view.label_share[i])) continue;
      patches.push_back({view.probabilities[i], view.labels[i], image_of.at(view.group)});
    }
  }
  return patches;
}

/// The curve through every patch, thinned to steps of 1/200 in recall.
std::vector<PrecisionRecallPoint> precision_recall_of(const ScoredPatches& ranked, int positives) {
  constexpr int steps = 200;
  std::vector<PrecisionRecallPoint> points;
  double found = 0, taken = 0;
  int next_step = 0;
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    found += ranked[i].label;
    ++taken;
    const bool inside_tie = i + 1 < ranked.size() && ranked[i + 1].score == ranked[i].score;
    if (inside_tie || found * steps < static_cast<double>(next_step) * positives || found == 0) continue;
    points.push_back({ranked[i].score, found / taken, found / positives});
    next_step = static_cast<int>(found * steps / positives) + 1;
  }
  return points;
}

std::vector<CalibrationBin> calibration_of(const ScoredPatches& patches, int bins) {
  std::vector<CalibrationBin> result(bins);
  for (const ScoredPatch& patch : patches) {
    CalibrationBin& bin = result[std::min(static_cast<int>(patch.score * bins), bins - 1)];
    ++bin.patches;
    bin.mean_probability += patch.score;
    bin.positive_share += patch.label;
  }
  for (int i = 0; i < bins; ++i) {
    result[i].low = static_cast<double>(i) / bins;
    result[i].high = static_cast<double>(i + 1) / bins;
    result[i].mean_probability = share_of(result[i].mean_probability, result[i].patches);
    result[i].positive_share = share_of(result[i].positive_share, result[i].patches);
  }
  return result;
}

ViewResult result_of(const ScoredView& view) {
  const auto best = std::max_element(view.probabilities.begin(), view.probabilities.end());
  return {view.source,
          view.class_name,
          average_precision(view.probabilities, view.labels),
          view.labels[static_cast<std::size_t>(best - view.probabilities.begin())] == 1,
          *best,
          view.visible_label_share};
}

bool has_label(const ViewResult& view) {
  return !std::isnan(view.average_precision);
}

std::vector<LabelShareRow> label_shares_of(const std::vector<ViewResult>& views) {
  std::vector<LabelShareRow> rows{{0, 0, 0, 0, 0}};
  for (std::size_t i = 1; i < std::size(label_share_limits); ++i) {
    rows.push_back({label_share_limits[i - 1], label_share_limits[i], 0, 0, 0});
  }
  for (const ViewResult& view : views) {
    // A label without a patch on the contour counts as one that cannot be seen.
    const double share = has_label(view) ? std::min(view.visible_label_share, 1.0) : 0;
    const auto row =
        std::find_if(rows.begin(), rows.end(), [&](const LabelShareRow& r) { return share <= r.high; });
    ++row->views;
    row->hits += view.hit ? 1 : 0;
    row->mean_best_probability += view.best_probability;
  }
  for (LabelShareRow& row : rows) row.mean_best_probability = share_of(row.mean_best_probability, row.views);
  return rows;
}

std::vector<ViewResult> worst_of(std::vector<ViewResult> views, int count) {
  views.erase(std::remove_if(views.begin(), views.end(), [](const ViewResult& v) { return !has_label(v); }),
              views.end());
  std::stable_sort(views.begin(), views.end(), [](const ViewResult& a, const ViewResult& b) {
    return a.average_precision < b.average_precision;
  });
  if (views.size() > static_cast<std::size_t>(count)) views.resize(static_cast<std::size_t>(count));
  return views;
}

LearningPoint learning_point(int images, const std::vector<ScoredView>& views, const ReportOptions& options) {
  const ScoredPatches ranked = detail::highest_first(patches_of(views));
  const int all_images = static_cast<int>(number_images(views).size());
  const auto measure = [&](const Weights& weights) { return detail::average_precision(ranked, weights); };
  return {images, measure(Weights(all_images, 1)),
          detail::resampled_interval(all_images, measure, options.resamples, options.seed)};
}

}  // namespace

void ReportOptions::check() const {
  detail::require_option(calibration_bins >= 1 && calibration_bins <= 1000,
                         "calibration_bins must be 1 to 1000");
  detail::require_option(worst_views >= 0, "worst_views must not be negative");
  detail::require_option(resamples >= 2 && resamples <= 100000, "resamples must be 2 to 100000");
}

EvaluationReport report_evaluation(const std::vector<ScoredView>& views, const ReportOptions& options) {
  options.check();
  EvaluationReport report;
  report.classes = evaluate_scores(views);
  report.images = static_cast<int>(number_images(views).size());

  const ScoredPatches ranked = detail::highest_first(patches_of(views));
  const ScoredPatches ranked_inner = detail::highest_first(patches_of(views, true));
  const auto positives =
      std::count_if(ranked.begin(), ranked.end(), [](const ScoredPatch& patch) { return patch.label == 1; });
  if (positives == 0 || positives == static_cast<std::ptrdiff_t>(ranked.size())) {
    throw InvalidInput("report: patches of both classes are needed, got " + std::to_string(positives) +
                       " positive of " + std::to_string(ranked.size()));
  }
  const auto interval = [&](const auto& measure) {
    return detail::resampled_interval(report.images, measure, options.resamples, options.seed);
  };
  report.average_precision_interval =
      interval([&](const Weights& weights) { return detail::average_precision(ranked, weights); });
  report.average_precision_border_ignored_interval =
      interval([&](const Weights& weights) { return detail::average_precision(ranked_inner, weights); });
  report.roc_area_interval =
      interval([&](const Weights& weights) { return detail::roc_area(ranked, weights); });
  report.calibration_error_interval = interval([&](const Weights& weights) {
    return detail::calibration_error(ranked, weights, options.calibration_bins);
  });

  report.precision_recall = precision_recall_of(ranked, static_cast<int>(positives));
  report.calibration = calibration_of(ranked, options.calibration_bins);
  std::vector<ViewResult> results;
  for (const ScoredView& view : views) {
    if (!view.labels.empty()) results.push_back(result_of(view));
  }
  report.label_shares = label_shares_of(results);
  report.worst = worst_of(std::move(results), options.worst_views);
  return report;
}

EvaluationReport report_training(const std::vector<LabelledView>& views, const TrainingSet& set,
                                 const Training& training, const ReportOptions& options) {
  const std::vector<ScoredView> held_out = held_out_views(views, set, training.held_out_probabilities);
  EvaluationReport report = report_evaluation(held_out, options);
  if (training.learning_curve.empty()) return report;
  for (const LearningStep& step : training.learning_curve) {
    report.learning_curve.push_back(
        learning_point(step.images, held_out_views(views, set, step.held_out_probabilities), options));
  }
  report.learning_curve.push_back(learning_point(training.images_of_folds, held_out, options));
  return report;
}

}  // namespace graspctx
