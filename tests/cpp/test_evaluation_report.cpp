// Reports: against naive counts, and by what their intervals and files have to keep.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "detail/patch_measures.hpp"
#include "graspctx/error.hpp"
#include "graspctx/evaluation_report.hpp"
#include "graspctx/io/report_file.hpp"
#include "training_data.hpp"

namespace graspctx {
namespace {

using nlohmann::json;
using testing::uniform;

/// Views of 30 patches; the model is right about three times in four. Every fifth has no label.
std::vector<ScoredView> scored_views(int count, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::vector<ScoredView> views;
  for (int i = 0; i < count; ++i) {
    ScoredView view;
    view.source = "scene " + std::to_string(i);
    view.class_name = i % 3 == 0 ? "mug" : "cup";
    view.group = 100 - i / 2;  // both views of a scene; in falling order
    view.visible_label_share = i % 5 == 4 ? 0 : 0.25 * uniform(generator);
    for (int patch = 0; patch < 30; ++patch) {
      const double p = std::floor(uniform(generator) * 50) / 50;  // ties
      view.probabilities.push_back(p);
      view.labels.push_back(i % 5 != 4 && uniform(generator) < 0.1 + 0.6 * p);
      view.label_share.push_back(view.labels.back() == 1 ? static_cast<float>(uniform(generator)) : 0.0f);
    }
    views.push_back(view);
  }
  return views;
}

/// Every patch of the views.
struct Patches {
  std::vector<double> p;
  std::vector<int> labels;
};
Patches all_patches(const std::vector<ScoredView>& views) {
  Patches all;
  for (const ScoredView& view : views) {
    all.p.insert(all.p.end(), view.probabilities.begin(), view.probabilities.end());
    all.labels.insert(all.labels.end(), view.labels.begin(), view.labels.end());
  }
  return all;
}

TEST(EvaluationReport, CurvesAreThoseOfNaiveCounts) {
  const std::vector<ScoredView> views = scored_views(40, 1);
  const EvaluationReport report = report_evaluation(views);
  const Patches all = all_patches(views);
  const double positives = static_cast<double>(std::count(all.labels.begin(), all.labels.end(), 1));
  EXPECT_EQ(report.images, 20);
  ASSERT_EQ(report.classes.size(), 3u);
  EXPECT_EQ(report.classes[2].patches, 40 * 30);

  ASSERT_GT(report.precision_recall.size(), 20u);
  ASSERT_LE(report.precision_recall.size(), 201u);
  double last_recall = 0;
  for (const PrecisionRecallPoint& point : report.precision_recall) {
    double taken = 0, found = 0;
    for (std::size_t i = 0; i < all.p.size(); ++i) {
      if (all.p[i] < point.threshold) continue;
      ++taken;
      found += all.labels[i];
    }
    EXPECT_DOUBLE_EQ(point.precision, found / taken);
    EXPECT_DOUBLE_EQ(point.recall, found / positives);
    EXPECT_GT(point.recall, last_recall);
    last_recall = point.recall;
  }
  EXPECT_EQ(last_recall, 1);

  ASSERT_EQ(report.calibration.size(), 10u);
  double error = 0;
  int patches = 0;
  for (const CalibrationBin& bin : report.calibration) {
    const auto inside = [&](double p) { return p >= bin.low - 1e-12 && p < bin.high - 1e-12; };
    double sum = 0, found = 0, count = 0;
    for (std::size_t i = 0; i < all.p.size(); ++i) {
      if (!inside(all.p[i])) continue;
      ++count;
      sum += all.p[i];
      found += all.labels[i];
    }
    EXPECT_EQ(bin.patches, count) << bin.low;
    EXPECT_NEAR(bin.mean_probability, sum / count, 1e-12);
    EXPECT_NEAR(bin.positive_share, found / count, 1e-12);
    patches += bin.patches;
    error += bin.patches * std::abs(bin.mean_probability - bin.positive_share);
  }
  EXPECT_EQ(patches, 1200);
  EXPECT_NEAR(error / patches, report.classes[2].calibration_error, 1e-12);
}

TEST(EvaluationReport, CountsHitsByVisibleLabelAndNamesTheWorst) {
  const std::vector<ScoredView> views = scored_views(60, 2);
  ReportOptions options;
  options.worst_views = 7;
  const EvaluationReport report = report_evaluation(views, options);
  int counted = 0, hits = 0;
  for (const LabelShareRow& row : report.label_shares) {
    int expected = 0, expected_hits = 0;
    for (const ScoredView& view : views) {
      const bool hidden = std::count(view.labels.begin(), view.labels.end(), 1) == 0;
      const double share = hidden ? 0 : view.visible_label_share;
      if (!(share > row.low || row.high == 0) || share > row.high) continue;
      ++expected;
      const auto best = std::max_element(view.probabilities.begin(), view.probabilities.end());
      expected_hits += view.labels[best - view.probabilities.begin()];
    }
    EXPECT_EQ(row.views, expected) << row.low << " to " << row.high;
    EXPECT_EQ(row.hits, expected_hits) << row.low << " to " << row.high;
    counted += row.views;
    hits += row.hits;
  }
  EXPECT_EQ(counted, 60);
  EXPECT_EQ(report.label_shares[0].views, 12);
  EXPECT_EQ(report.label_shares[0].hits, 0);
  EXPECT_EQ(static_cast<double>(hits) / (60 - 12), report.classes.back().top1);

  ASSERT_EQ(report.worst.size(), 7u);
  std::vector<double> precisions;
  for (const ScoredView& view : views) {
    const double precision = average_precision(view.probabilities, view.labels);
    if (!std::isnan(precision)) precisions.push_back(precision);
  }
  std::sort(precisions.begin(), precisions.end());
  for (std::size_t i = 0; i < report.worst.size(); ++i) {
    EXPECT_EQ(report.worst[i].average_precision, precisions[i]);
    const auto named = std::find_if(views.begin(), views.end(), [&](const ScoredView& view) {
      return view.source == report.worst[i].source;
    });
    EXPECT_EQ(average_precision(named->probabilities, named->labels), precisions[i]);
  }
}

TEST(EvaluationReport, IntervalsHoldTheFigureAndNarrowWithTheImages) {
  double last_width = 1;
  for (const int count : {20, 80, 320}) {
    const EvaluationReport report = report_evaluation(scored_views(count, 3));
    const ClassEvaluation& all = report.classes.back();
    const auto holds = [](const Interval& interval, double value) {
      return interval.low <= value && value <= interval.high;
    };
    EXPECT_TRUE(holds(report.average_precision_interval, all.average_precision));
    EXPECT_TRUE(
        holds(report.average_precision_border_ignored_interval, all.average_precision_border_ignored));
    EXPECT_TRUE(holds(report.roc_area_interval, all.roc_area));
    EXPECT_LT(report.calibration_error_interval.low, report.calibration_error_interval.high);
    const double width = report.roc_area_interval.high - report.roc_area_interval.low;
    EXPECT_LT(width, 0.7 * last_width);
    last_width = width;
  }
}

TEST(EvaluationReport, ResampledIntervalIsThatOfTheMeanOfImages) {
  // The mean of n values has a known interval: 1.96 standard errors to either side.
  std::mt19937 generator(5);
  std::vector<double> values;
  for (int i = 0; i < 200; ++i) values.push_back(uniform(generator));
  const auto mean_of = [&](const detail::Weights& weights) {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      sum += weights[i] * values[i];
      count += weights[i];
    }
    EXPECT_EQ(count, 200);
    return sum / count;
  };
  const Interval interval = detail::resampled_interval(200, mean_of, 4000, 1);
  const double mean = mean_of(detail::Weights(200, 1));
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  const double expected = 2 * 1.96 * std::sqrt(squares / 200 / 200);
  EXPECT_NEAR(interval.high - interval.low, expected, 0.06 * expected);
  EXPECT_NEAR((interval.high + interval.low) / 2, mean, 0.05 * expected);
}

TEST(EvaluationReport, WeightsCountAsRepeatedPatches) {
  const detail::ScoredPatches patches{{0.9, 1, 0}, {0.8, 0, 1}, {0.8, 1, 2}, {0.3, 0, 0}, {0.1, 1, 1}};
  const detail::Weights weights{2, 3, 1};
  std::vector<double> scores;
  std::vector<int> labels;
  for (const detail::ScoredPatch& patch : patches) {
    for (int i = 0; i < weights[patch.image]; ++i) {
      scores.push_back(patch.score);
      labels.push_back(patch.label);
    }
  }
  EXPECT_DOUBLE_EQ(detail::average_precision(patches, weights), average_precision(scores, labels));
  EXPECT_DOUBLE_EQ(detail::roc_area(patches, weights), roc_area(scores, labels));
  EXPECT_DOUBLE_EQ(detail::calibration_error(patches, weights, 10),
                   expected_calibration_error(scores, labels));
  EXPECT_TRUE(std::isnan(detail::average_precision(patches, {0, 0, 0})));
}

TEST(EvaluationReport, RefusesWhatCannotBeMeasured) {
  std::vector<ScoredView> views = scored_views(5, 1);
  for (ScoredView& view : views) std::fill(view.labels.begin(), view.labels.end(), 0);
  EXPECT_THROW(report_evaluation(views), InvalidInput);
  EXPECT_THROW(report_evaluation({}), InvalidInput);
  ReportOptions options;
  options.calibration_bins = 0;
  EXPECT_THROW(report_evaluation(scored_views(5, 1), options), InvalidInput);
}

// -------------------------------------------------------------------------------------------- of trainings

TEST(TrainingReport, MeasuresTrueMasksAlone) {
  std::vector<LabelledView> views;
  for (int i = 0; i < 6; ++i) {
    const auto mug = testing::draw_mug({480, 400}, {180 + 10 * i, 170}, 40 + 3 * i);
    views.push_back({"mug " + std::to_string(i), "mug", i, mug.image, mug.mask, mug.handle});
  }
  DescriptorOptions descriptor;
  descriptor.fovea.object_px = 120;
  const TrainingSet set = build_training_set(views, descriptor);
  TrainOptions options = testing::fixed_options();
  options.learning_curve = {0.5};
  const Training training = train_and_validate(set.features, set.labels, set.groups, options);
  const std::vector<ScoredView> held_out = held_out_views(views, set, training.held_out_probabilities);
  ASSERT_EQ(held_out.size(), views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const LabelledPatches described = describe_labelled_view(views[i], descriptor);
    EXPECT_EQ(held_out[i].labels, described.labels);
    EXPECT_EQ(held_out[i].label_share, described.label_share);
    EXPECT_EQ(held_out[i].visible_label_share, described.visible_label_share);
    EXPECT_EQ(held_out[i].source, views[i].source);
  }
  const EvaluationReport report = report_training(views, set, training);
  EXPECT_EQ(report.classes.front().average_precision, evaluate_scores(held_out).front().average_precision);
  ASSERT_EQ(report.learning_curve.size(), 2u);
  EXPECT_LT(report.learning_curve[0].images, report.learning_curve[1].images);
  EXPECT_EQ(report.learning_curve[1].average_precision, report.classes.front().average_precision);
  EXPECT_THROW(held_out_views(views, set, {0.5}), InvalidInput);
}

// ------------------------------------------------------------------------------------------------- files

TEST(ReportFile, JsonHoldsTheFiguresAndNullForWhatIsNotDefined) {
  EvaluationReport report = report_evaluation(scored_views(20, 4));
  report.learning_curve = {{3, 0.25, {0.125, 0.5}}, {6, std::nan(""), {std::nan(""), std::nan("")}}};
  const std::string text = report_to_json({"Title", {{"data set", "some \xff folder"}}}, report);
  EXPECT_EQ(text, report_to_json({"Title", {{"data set", "some \xff folder"}}}, report));
  const json document = json::parse(text);
  EXPECT_EQ(document["schema"], 1);
  EXPECT_EQ(document["images"], 10);
  EXPECT_EQ(document["classes"].back()["ap"], report.classes.back().average_precision);
  EXPECT_EQ(document["intervals"]["auc"][1], report.roc_area_interval.high);
  EXPECT_EQ(document["calibration"].size(), 10u);
  EXPECT_EQ(document["learning_curve"][0]["ap_interval"], (json{0.125, 0.5}));
  EXPECT_TRUE(document["learning_curve"][1]["ap"].is_null());
  EXPECT_EQ(document["worst"][0]["source"], report.worst[0].source);
}

TEST(ReportFile, HtmlEscapesNames) {
  std::vector<ScoredView> views = scored_views(20, 4);
  for (ScoredView& view : views) view.source = "<script>'&\"" + view.source;
  const std::string html = report_to_html({"A <b> & c", {{"data <set>", "\"x\""}}}, report_evaluation(views));
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_NE(html.find("&lt;script&gt;&#39;&amp;&quot;scene"), std::string::npos);
  EXPECT_NE(html.find("<h1>A &lt;b&gt; &amp; c</h1>"), std::string::npos);
  EXPECT_EQ(html.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace graspctx
