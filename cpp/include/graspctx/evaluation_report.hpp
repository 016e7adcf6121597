#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "graspctx/evaluation.hpp"
#include "graspctx/export.hpp"

namespace graspctx {

struct GRASPCTX_EXPORT ReportOptions {
  int calibration_bins = 10;
  int worst_views = 12;
  int resamples = 400;  // of the images, for the intervals
  std::uint32_t seed = 1;
  void check() const;
};

/// The patches of which at least `threshold` is answered.
struct PrecisionRecallPoint {
  double threshold = 0, precision = 0, recall = 0;
};

/// The patches whose probability lies from low to high.
struct CalibrationBin {
  double low = 0, high = 0;
  int patches = 0;
  double mean_probability = 0, positive_share = 0;  // NaN without patches
};

/// The views of which so much of the object is labelled: over low, up to high.
struct LabelShareRow {
  double low = 0, high = 0;          // both 0: the region cannot be seen
  int views = 0, hits = 0;           // a hit: the most probable patch is positive
  double mean_best_probability = 0;  // NaN without views
};

struct ViewResult {
  std::string source, class_name;
  double average_precision = 0;
  bool hit = false;
  double best_probability = 0;
  double visible_label_share = 0;
};

struct LearningPoint {
  int images = 0;                // trained on
  double average_precision = 0;  // strict, on images that were held out
  Interval average_precision_interval;
};

/// What a model reaches on labelled views, to be looked at. Intervals are of 95 %: Wilson's for top-1, the
/// others by resampling images (groups) with replacement. They are of all views together.
struct EvaluationReport {
  std::vector<ClassEvaluation> classes;  // as evaluate_scores; the last row is of all views
  int images = 0;                        // groups
  Interval average_precision_interval, average_precision_border_ignored_interval, roc_area_interval,
      calibration_error_interval;
  std::vector<PrecisionRecallPoint> precision_recall;  // recall rises; at most 201 points
  std::vector<CalibrationBin> calibration;
  std::vector<LabelShareRow> label_shares;
  std::vector<ViewResult> worst;              // with a label, lowest average precision first
  std::vector<LearningPoint> learning_curve;  // of a training that was asked for one; images rise
};

/// Throws InvalidInput if no patch is positive or none is negative.
GRASPCTX_EXPORT EvaluationReport report_evaluation(const std::vector<ScoredView>& views,
                                                   const ReportOptions& options = {});

/// The same for a training, from what its cross-validation held out (METHOD 5): nothing is measured on rows
/// that were trained on. views and set: see held_out_views.
GRASPCTX_EXPORT EvaluationReport report_training(const std::vector<LabelledView>& views,
                                                 const TrainingSet& set, const Training& training,
                                                 const ReportOptions& options = {});

}  // namespace graspctx
