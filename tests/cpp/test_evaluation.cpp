// Metrics: against their definitions written naively, and against known values.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <random>

#include "graspctx/error.hpp"
#include "graspctx/evaluation.hpp"
#include "synthetic.hpp"
#include "training_data.hpp"

namespace graspctx {
namespace {

using testing::draw_mug;
using testing::uniform;

struct Scored {
  std::vector<double> scores;
  std::vector<int> labels;
};

/// Scores in `levels` steps (few: many ties), higher for positives on average.
Scored random_scores(int count, int levels, double prior, std::uint32_t seed) {
  std::mt19937 generator(seed);
  Scored result;
  for (int i = 0; i < count; ++i) {
    const int label = uniform(generator) < prior;
    const double score = std::min(0.999, 0.7 * uniform(generator) + 0.3 * label);
    result.scores.push_back(std::floor(score * levels) / levels);
    result.labels.push_back(label);
  }
  return result;
}

/// For each positive, the precision among all that score at least as high.
double naive_average_precision(const Scored& s) {
  double sum = 0, positives = 0;
  for (std::size_t i = 0; i < s.scores.size(); ++i) {
    if (s.labels[i] == 0) continue;
    double taken = 0, found = 0;
    for (std::size_t j = 0; j < s.scores.size(); ++j) {
      if (s.scores[j] < s.scores[i]) continue;
      taken += 1;
      found += s.labels[j];
    }
    sum += found / taken;
    positives += 1;
  }
  return sum / positives;
}

/// Share of the pairs of a positive and a negative in the right order.
double naive_roc_area(const Scored& s) {
  double sum = 0, pairs = 0;
  for (std::size_t i = 0; i < s.scores.size(); ++i) {
    for (std::size_t j = 0; j < s.scores.size(); ++j) {
      if (s.labels[i] == 0 || s.labels[j] == 1) continue;
      pairs += 1;
      sum += s.scores[i] > s.scores[j] ? 1 : s.scores[i] == s.scores[j] ? 0.5 : 0;
    }
  }
  return sum / pairs;
}

/// Over the bins, the share of rows times the distance of mean probability and share of positives.
double naive_calibration_error(const Scored& s, int bins) {
  double error = 0;
  for (int bin = 0; bin < bins; ++bin) {
    double rows = 0, probability = 0, positives = 0;
    for (std::size_t i = 0; i < s.scores.size(); ++i) {
      const bool last = bin == bins - 1;
      const double low = static_cast<double>(bin) / bins, high = (bin + 1.0) / bins;
      if (s.scores[i] < low || (s.scores[i] >= high && !last)) continue;
      rows += 1;
      probability += s.scores[i];
      positives += s.labels[i];
    }
    if (rows == 0) continue;
    error += rows / static_cast<double>(s.scores.size()) * std::abs(probability / rows - positives / rows);
  }
  return error;
}

TEST(Evaluation, AgreesWithTheNaiveDefinitions) {
  std::uint32_t seed = 0;
  for (const int levels : {2, 3, 16, 128, 1 << 20}) {
    for (const double prior : {0.02, 0.3, 0.9}) {
      const Scored s = random_scores(400, levels, prior, ++seed);
      EXPECT_NEAR(average_precision(s.scores, s.labels), naive_average_precision(s), 1e-12);
      EXPECT_NEAR(roc_area(s.scores, s.labels), naive_roc_area(s), 1e-12);
      for (const int bins : {1, 8, 64}) {  // powers of two: the borders of the bins are exact
        EXPECT_NEAR(expected_calibration_error(s.scores, s.labels, bins), naive_calibration_error(s, bins),
                    1e-12);
      }
    }
  }
}

TEST(Evaluation, RankingsOnlyDependOnTheOrder) {
  const Scored s = random_scores(300, 40, 0.2, 9);
  std::vector<double> bent;
  for (const double score : s.scores) bent.push_back(std::exp(3 * score) - 100);
  EXPECT_EQ(average_precision(bent, s.labels), average_precision(s.scores, s.labels));
  EXPECT_EQ(roc_area(bent, s.labels), roc_area(s.scores, s.labels));
  std::vector<double> reversed;
  for (const double score : s.scores) reversed.push_back(-score);
  EXPECT_NEAR(roc_area(reversed, s.labels), 1 - roc_area(s.scores, s.labels), 1e-12);
}

TEST(Evaluation, KnownRankings) {
  EXPECT_EQ(average_precision({.9, .8, .2, .1}, {1, 1, 0, 0}), 1);
  EXPECT_EQ(average_precision({.9, .8, .2, .1}, {0, 0, 0, 1}), 0.25);
  EXPECT_DOUBLE_EQ(average_precision({.9, .8, .2, .1}, {1, 0, 1, 0}), (1 + 2.0 / 3) / 2);
  EXPECT_DOUBLE_EQ(average_precision({.5, .5, .5, .5}, {1, 0, 0, 0}), 0.25);  // ties are no luck
  EXPECT_EQ(roc_area({.9, .8, .2, .1}, {1, 1, 0, 0}), 1);
  EXPECT_EQ(roc_area({.5, .5, .5, .5}, {1, 0, 0, 1}), 0.5);
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(roc_area({inf, -inf}, {1, 0}), 1);
  EXPECT_EQ(expected_calibration_error({1, 0, 1, 0}, {1, 0, 1, 0}), 0);
  EXPECT_DOUBLE_EQ(expected_calibration_error({1, 1, 0, 0}, {0, 1, 1, 0}), 0.5);
  EXPECT_DOUBLE_EQ(expected_calibration_error({.25, .25, .25, .25}, {0, 1, 0, 0}), 0);
}

TEST(Evaluation, NothingToMeasureIsNotANumber) {
  EXPECT_TRUE(std::isnan(average_precision({}, {})));
  EXPECT_TRUE(std::isnan(average_precision({.5}, {0})));
  EXPECT_EQ(average_precision({.5}, {1}), 1);
  EXPECT_TRUE(std::isnan(roc_area({.5, .6}, {1, 1})));
  EXPECT_TRUE(std::isnan(roc_area({.5, .6}, {0, 0})));
  EXPECT_TRUE(std::isnan(expected_calibration_error({}, {})));
}

TEST(Evaluation, RefusesWhatIsNoScore) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(average_precision({.1, .2}, {1}), InvalidInput);
  EXPECT_THROW(roc_area({.1, nan}, {1, 0}), InvalidInput);
  EXPECT_THROW(roc_area({.1, .2}, {1, 2}), InvalidInput);
  EXPECT_THROW(expected_calibration_error({1.01}, {1}), InvalidInput);
  EXPECT_THROW(expected_calibration_error({-0.01}, {1}), InvalidInput);
  EXPECT_THROW(expected_calibration_error({0.5}, {1}, 0), InvalidInput);
  EXPECT_THROW(wilson_interval(3, 2), InvalidInput);
  EXPECT_THROW(wilson_interval(-1, 2), InvalidInput);
}

TEST(Evaluation, WilsonIntervalSolvesItsEquation) {
  const double z = 1.959963984540054;
  for (const int trials : {1, 2, 10, 60, 1000}) {
    for (const int successes : {0, 1, trials / 2, trials - 1, trials}) {
      const Interval interval = wilson_interval(successes, trials);
      const double share = static_cast<double>(successes) / trials;
      // Both ends lie z standard errors of their own from the share: (p − share)² = z² p (1 − p) / n.
      for (const double p : {interval.low, interval.high}) {
        EXPECT_NEAR(std::pow(p - share, 2), z * z * p * (1 - p) / trials, 1e-12);
      }
      EXPECT_LE(interval.low, share);
      EXPECT_GE(interval.high, share);
      EXPECT_LT(interval.low, interval.high);
    }
  }
  // Known values: 0 and 8 of 10, to four digits.
  EXPECT_EQ(wilson_interval(0, 10).low, 0);
  EXPECT_NEAR(wilson_interval(0, 10).high, 0.2775, 5e-5);
  EXPECT_NEAR(wilson_interval(8, 10).low, 0.4902, 5e-5);
  EXPECT_NEAR(wilson_interval(8, 10).high, 0.9433, 5e-5);
  EXPECT_EQ(wilson_interval(10, 10).high, 1);
  EXPECT_EQ(wilson_interval(0, 0).low, 0);
  EXPECT_EQ(wilson_interval(0, 0).high, 1);
}

// --------------------------------------------------------------------------------------------- whole views

std::vector<LabelledView> drawn_views(int count, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::vector<LabelledView> views;
  for (int i = 0; i < count; ++i) {
    const int unit = 40 + static_cast<int>(30 * uniform(generator));
    const auto mug = draw_mug({480, 400}, {180 + static_cast<int>(60 * uniform(generator)), 170}, unit);
    LabelledView view;
    view.source = "drawn mug " + std::to_string(i);
    view.class_name = i % 3 == 0 ? "first" : "second";
    view.group = i;
    view.image = mug.image;
    view.mask = mug.mask;
    view.label = mug.handle.clone();
    if (i % 4 == 1) {  // only a little of it is labelled
      view.label.setTo(0);
      std::vector<cv::Point> pixels;
      cv::findNonZero(mug.handle, pixels);
      cv::circle(view.label, pixels[pixels.size() / 2], 3, cv::Scalar(255), cv::FILLED);
      view.label &= mug.mask;
    }
    if (i % 5 == 4) view.label.setTo(0);  // the handle is out of sight
    views.push_back(view);
  }
  return views;
}

TEST(EvaluateModel, CountsEachClassAndAll) {
  const std::vector<LabelledView> training = drawn_views(12, 1);
  DescriptorOptions descriptor;
  descriptor.fovea.object_px = 120;
  AugmentOptions augment;
  augment.degraded_masks = 0;
  const TrainingSet set = build_training_set(training, descriptor, augment);
  // Few vectors and a wide kernel: good, but not so good that every figure is 1.
  GraspModel model = train_model(set.features, set.labels, set.groups, testing::fixed_options(0.5, 0.3));
  model.descriptor = descriptor;

  const auto views_of_test = [] {
    std::vector<LabelledView> views = drawn_views(24, 2);
    std::swap(views[0], views[1]);  // "second" comes first
    return views;
  };
  const std::vector<ClassEvaluation> rows = evaluate_model(model, views_of_test());
  const std::vector<LabelledView> views = views_of_test();  // pixels of its own
  std::vector<LabelledPatches> described_views;
  for (const LabelledView& view : views) described_views.push_back(describe_labelled_view(view, descriptor));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].class_name, "second");
  EXPECT_EQ(rows[1].class_name, "first");
  EXPECT_EQ(rows[2].class_name, "all");

  for (const ClassEvaluation& row : rows) {
    Scored all, inner;
    double chance = 0;
    int labelled = 0, unlabelled = 0, hits = 0, large = 0, large_hits = 0;
    for (std::size_t index = 0; index < views.size(); ++index) {
      const LabelledView& view = views[index];
      const LabelledPatches& described = described_views[index];
      if (row.class_name != "all" && view.class_name != row.class_name) continue;
      const Eigen::VectorXd p = model.predict_probability(described.patches.features);
      double positives = 0;
      for (std::size_t i = 0; i < described.labels.size(); ++i) {
        const bool border = described.labels[i] == 1 && described.label_share[i] < 0.5f;
        for (Scored* scored : {&all, &inner}) {
          if (scored == &inner && border) continue;
          scored->scores.push_back(p[static_cast<Eigen::Index>(i)]);
          scored->labels.push_back(described.labels[i]);
        }
        positives += described.labels[i];
      }
      if (positives == 0) {
        ++unlabelled;
        continue;
      }
      ++labelled;
      chance += positives / static_cast<double>(p.size());
      Eigen::Index best = 0;
      p.maxCoeff(&best);
      const int hit = described.labels[static_cast<std::size_t>(best)];
      hits += hit;
      if (cv::countNonZero(view.label) > 0.02 * cv::countNonZero(view.mask)) {
        ++large;
        large_hits += hit;
      }
    }
    ASSERT_GT(labelled, 1);
    ASSERT_GT(unlabelled, 0);
    ASSERT_GT(large, 0);
    ASSERT_LT(large, labelled);
    EXPECT_EQ(row.views, labelled);
    EXPECT_EQ(row.views_without_label, unlabelled);
    EXPECT_EQ(row.views_large_label, large);
    EXPECT_EQ(row.patches, static_cast<int>(all.labels.size()));
    EXPECT_NEAR(row.average_precision, naive_average_precision(all), 1e-12);
    EXPECT_NEAR(row.average_precision_border_ignored, naive_average_precision(inner), 1e-12);
    EXPECT_NEAR(row.roc_area, naive_roc_area(all), 1e-12);
    EXPECT_NEAR(row.calibration_error, naive_calibration_error(all, 10), 1e-9);
    EXPECT_DOUBLE_EQ(row.top1, static_cast<double>(hits) / labelled);
    EXPECT_DOUBLE_EQ(row.top1_large_label, static_cast<double>(large_hits) / large);
    EXPECT_DOUBLE_EQ(row.top1_chance, chance / labelled);
    EXPECT_EQ(row.top1_interval.low, wilson_interval(hits, labelled).low);
    EXPECT_EQ(row.top1_interval.high, wilson_interval(hits, labelled).high);
    const auto positives = static_cast<double>(std::count(all.labels.begin(), all.labels.end(), 1));
    EXPECT_DOUBLE_EQ(row.label_prior, positives / static_cast<double>(all.labels.size()));
    EXPECT_GT(row.average_precision, 2 * row.label_prior);  // and it has learnt something
    EXPECT_LT(row.average_precision, 0.999);
  }
  EXPECT_EQ(rows[2].patches, rows[0].patches + rows[1].patches);
}

TEST(EvaluateModel, OneClassHasNoRowForAll) {
  std::vector<LabelledView> views = drawn_views(6, 1);
  for (LabelledView& view : views) view.class_name = "mug";
  AugmentOptions augment;
  augment.degraded_masks = 0;
  const TrainingSet set = build_training_set(views, {}, augment);
  const GraspModel model = train_model(set.features, set.labels, set.groups, testing::fixed_options());
  ASSERT_EQ(evaluate_model(model, views).size(), 1u);
  EXPECT_EQ(evaluate_model(model, views)[0].class_name, "mug");
  EXPECT_TRUE(evaluate_model(model, {}).empty());
}

}  // namespace
}  // namespace graspctx
