// What a training tells of itself, and training on top of a base.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "graspctx/error.hpp"
#include "graspctx/evaluation.hpp"
#include "graspctx/grasp_model.hpp"
#include "training_data.hpp"

namespace graspctx {
namespace {

using testing::fixed_options;
using testing::make_rows;
using testing::Rows;
using testing::tiny_descriptor;

Training train(const Rows& rows, const TrainOptions& options) {
  return train_and_validate(rows.features, rows.labels, rows.groups, options);
}

double precision_of(const GraspModel& model, const Rows& rows) {
  const Eigen::VectorXd p = model.predict_probability(rows.features);
  return average_precision({p.begin(), p.end()}, rows.labels);
}

std::vector<std::uint8_t> bytes_of(GraspModel model) {
  model.descriptor = tiny_descriptor();
  return model.to_safetensors();
}

/// Rows of image `group`, the most probable first.
std::vector<int> ranking_of(const Training& training, const Rows& rows, int group) {
  std::vector<int> chosen;
  for (std::size_t row = 0; row < rows.groups.size(); ++row) {
    if (rows.groups[row] == group) chosen.push_back(static_cast<int>(row));
  }
  std::sort(chosen.begin(), chosen.end(), [&](int a, int b) {
    return training.held_out_probabilities[a] > training.held_out_probabilities[b];
  });
  return chosen;
}

TEST(Validation, LeavesTheModelAsItIs) {
  const Rows rows = make_rows(12, 40, 3, 1);
  TrainOptions options;
  const GraspModel model = train_model(rows.features, rows.labels, rows.groups, options);
  options.learning_curve = {0.25, 0.5};
  EXPECT_EQ(bytes_of(train(rows, options).model), bytes_of(model));
}

TEST(Validation, KnowsNothingOfTheLabelsOfAHeldOutImage) {
  const Rows rows = make_rows(10, 40, 6, 2);
  Rows swapped = rows;  // as many positives, but others
  for (int row = 0; row < 40; ++row) swapped.labels[row] = rows.labels[39 - row];
  ASSERT_NE(swapped.labels, rows.labels);
  const Training training = train(rows, fixed_options()), other = train(swapped, fixed_options());
  EXPECT_EQ(ranking_of(training, rows, 0), ranking_of(other, swapped, 0));
  const auto differs = [&](int group) {
    return ranking_of(training, rows, group) != ranking_of(other, swapped, group);
  };
  EXPECT_TRUE(differs(1) || differs(2) || differs(3));  // those were trained on it
}

TEST(Validation, PromisesWhatUnseenImagesShow) {
  const Rows rows = make_rows(40, 60, 12, 3), test = make_rows(40, 60, 12, 4);
  const Training training = train(rows, fixed_options());
  ASSERT_EQ(training.held_out_probabilities.size(), rows.labels.size());
  EXPECT_EQ(training.images_of_folds, 32);
  const double promised = average_precision(training.held_out_probabilities, rows.labels);
  EXPECT_NEAR(promised, precision_of(training.model, test), 0.05);
  EXPECT_LT(expected_calibration_error(training.held_out_probabilities, rows.labels), 0.03);
}

TEST(Validation, LearningCurveRisesWithTheImages) {
  const Rows rows = make_rows(40, 10, 30, 5);
  TrainOptions options = fixed_options(1, 0.5);
  options.learning_curve = {0.05, 0.25, 0.5};
  const Training training = train(rows, options);
  ASSERT_EQ(training.learning_curve.size(), 3u);
  const std::vector<int> expected_images{2, 8, 16};
  double fewer = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const LearningStep& step = training.learning_curve[i];
    EXPECT_EQ(step.images, expected_images[i]);
    const double precision = average_precision(step.held_out_probabilities, rows.labels);
    EXPECT_GT(precision, fewer + 0.05);
    fewer = precision;
  }
  EXPECT_GT(average_precision(training.held_out_probabilities, rows.labels), fewer + 0.05);
  for (const double wrong : {0.0, 1.0, -0.5, std::nan("")}) {
    options.learning_curve = {wrong};
    EXPECT_THROW(train(rows, options), InvalidInput) << wrong;
  }
}

TEST(Validation, LearningCurveTakesImagesUntilBothClassesAreThere) {
  Rows rows = make_rows(20, 30, 6, 6);
  for (std::size_t row = 0; row < rows.labels.size(); ++row) {
    if (rows.groups[row] >= 4) rows.labels[row] = 0;  // most images show no grasp region
  }
  TrainOptions options = fixed_options();
  options.learning_curve = {0.01};
  const Training training = train(rows, options);
  EXPECT_GE(training.learning_curve[0].images, 1);
  EXPECT_LE(training.learning_curve[0].images, training.images_of_folds);
}

// -------------------------------------------------------------------------------------------- warm starts

/// The rows of make_rows with half of the columns mirrored: another direction is positive.
Rows other_class(int groups, int rows_per_group, int dimension, std::uint32_t seed) {
  Rows rows = make_rows(groups, rows_per_group, dimension, seed);
  for (int i = 0; i < dimension; ++i) {
    if (i % 4 >= 2) rows.features.col(i) = (2.0f * static_cast<float>(i) - rows.features.col(i).array());
  }
  return rows;
}

TEST(WarmStart, FewImagesOnTopOfABaseBeatBothAlone) {
  const GraspModel base = train(make_rows(40, 60, 12, 1), fixed_options()).model;
  const Rows own = other_class(5, 40, 12, 2), test_own = other_class(20, 60, 12, 3);
  const Rows test_base = make_rows(20, 60, 12, 4);
  const Training warm = train(own, warm_start(base));
  EXPECT_GT(precision_of(warm.model, test_own), precision_of(base, test_own) + 0.1);
  const GraspModel scratch = train(own, fixed_options()).model;
  EXPECT_GT(precision_of(warm.model, test_base), precision_of(scratch, test_base) + 0.1);
  EXPECT_GT(precision_of(warm.model, test_base), precision_of(base, test_base) - 0.1);
  // Nothing of the base is held out or counted as the caller's.
  EXPECT_EQ(warm.held_out_probabilities.size(), own.labels.size());
  EXPECT_EQ(warm.model.provenance.at("training.rows"), std::to_string(own.labels.size()));
  EXPECT_EQ(warm.model.provenance.at("training.base_rows"), std::to_string(base.coefficients.size()));
  EXPECT_EQ(warm.model.svm_c, base.svm_c);
  EXPECT_NEAR(warm.model.gamma, base.gamma, 1e-12);
}

TEST(WarmStart, IsTrainedOnWhatTheBaseWasTaughtAndTheRows) {
  const Rows taught = make_rows(10, 40, 6, 7), own = other_class(6, 40, 6, 8);
  const GraspModel base = train(taught, fixed_options()).model;
  const GraspModel warm = train(own, warm_start(base)).model;
  int of_base = 0, of_own = 0;
  for (Eigen::Index i = 0; i < warm.support_vectors.rows(); ++i) {
    const Eigen::RowVectorXf vector =
        warm.support_vectors.row(i).cwiseProduct(warm.scale.transpose()) + warm.mean.transpose();
    const auto is_row_of = [&](const Rows& rows) {
      Eigen::Index nearest = 0;
      const float squared = (rows.features.rowwise() - vector).rowwise().squaredNorm().minCoeff(&nearest);
      return squared < 1e-6f && rows.labels[nearest] == (warm.coefficients[i] > 0 ? 1 : 0);
    };
    of_base += is_row_of(taught);
    of_own += is_row_of(own);
  }
  EXPECT_EQ(of_base + of_own, warm.support_vectors.rows());
  EXPECT_GT(of_base, 20);
  EXPECT_LE(of_base, base.support_vectors.rows());
  EXPECT_GT(of_own, 20);
}

TEST(WarmStart, SameBytesAgain) {
  const GraspModel base = train(make_rows(10, 40, 3, 1), fixed_options()).model;
  const Rows own = other_class(6, 40, 3, 2);
  GraspModel of_file = base;
  of_file.descriptor = tiny_descriptor();
  const std::vector<std::uint8_t> file = of_file.to_safetensors();
  of_file = GraspModel::from_safetensors(file.data(), file.size());
  EXPECT_EQ(bytes_of(train(own, warm_start(base)).model), bytes_of(train(own, warm_start(of_file)).model));
}

TEST(WarmStart, RefusesABaseThatDoesNotFit) {
  GraspModel base = train(make_rows(10, 40, 3, 1), fixed_options()).model;
  const Rows wide = make_rows(6, 40, 6, 2);
  try {
    train(wide, warm_start(base));
    FAIL();
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("the base takes 3 features, the rows have 6"), std::string::npos) << message;
  }
  base.coefficients[0] = 0;
  EXPECT_THROW(train(make_rows(6, 40, 3, 2), warm_start(base)), InvalidInput);
}

}  // namespace
}  // namespace graspctx
