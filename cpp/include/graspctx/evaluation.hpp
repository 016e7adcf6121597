#pragma once
#include <string>
#include <vector>

#include "graspctx/dataset.hpp"
#include "graspctx/export.hpp"
#include "graspctx/grasp_model.hpp"

namespace graspctx {

/// Area under the precision-recall curve by steps (ties counted together); NaN without positives.
GRASPCTX_EXPORT double average_precision(const std::vector<double>& scores, const std::vector<int>& labels);
/// Area under the ROC curve, ties as one half; NaN if one class is missing.
GRASPCTX_EXPORT double roc_area(const std::vector<double>& scores, const std::vector<int>& labels);
/// Expected calibration error over equal-width bins of the probability.
GRASPCTX_EXPORT double expected_calibration_error(const std::vector<double>& probabilities,
                                                  const std::vector<int>& labels, int bins = 10);
/// 95 % interval of a share of `successes` in `trials` (Wilson).
struct Interval {
  double low = 0, high = 1;
};
GRASPCTX_EXPORT Interval wilson_interval(int successes, int trials);

/// What a model reaches on the labelled views of one class.
struct ClassEvaluation {
  std::string class_name;
  int views = 0;                // with at least one positive patch
  int views_without_label = 0;  // the region cannot be seen: they count for AP and AUC, not for top-1
  int patches = 0;
  double label_prior = 0;                       // share of positive patches
  double average_precision = 0;                 // strict: any overlap is positive
  double average_precision_border_ignored = 0;  // patches labelled by less than half left out
  double roc_area = 0;
  double calibration_error = 0;
  double top1 = 0;  // share of views whose most probable patch is positive
  Interval top1_interval;
  double top1_chance = 0;       // mean share of positive patches in a view
  double top1_large_label = 0;  // of the views where the label is over 2 % of the object
  int views_large_label = 0;
};

/// The patches of one labelled view, and what a model answers for them.
struct ScoredView {
  std::string source, class_name;
  int group = 0;  // LabelledView::group
  double visible_label_share = 0;
  std::vector<int> labels;            // (M) 0 or 1
  std::vector<float> label_share;     // (M) share of the patch's pixels that are labelled
  std::vector<double> probabilities;  // (M) P(g = 1 | D)
};

/// A model's answers with the true masks.
GRASPCTX_EXPORT std::vector<ScoredView> score_views(const GraspModel& model,
                                                    const std::vector<LabelledView>& views);
/// The answers that a training's cross-validation gave for the views with their true masks. views and set: as
/// they were described by build_training_set. probabilities (R): Training::held_out_probabilities. Throws
/// InvalidInput for sizes that differ.
GRASPCTX_EXPORT std::vector<ScoredView> held_out_views(const std::vector<LabelledView>& views,
                                                       const TrainingSet& set,
                                                       const std::vector<double>& probabilities);

/// One row for each class in the order of first appearance, and, if there is more than one class, a last row
/// "all".
GRASPCTX_EXPORT std::vector<ClassEvaluation> evaluate_scores(const std::vector<ScoredView>& views);

/// Evaluate with the true masks, one row for each class in the order of first appearance, and, if there is
/// more than one class, a last row "all".
GRASPCTX_EXPORT std::vector<ClassEvaluation> evaluate_model(const GraspModel& model,
                                                            const std::vector<LabelledView>& views);

}  // namespace graspctx
