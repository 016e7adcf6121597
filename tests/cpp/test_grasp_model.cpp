// The classifier: against libsvm's own prediction, and by what its training has to keep.
#include <gtest/gtest.h>
#include <libsvm/svm.h>
#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <locale>
#include <memory>
#include <sstream>
#include <thread>

#include "graspctx/error.hpp"
#include "graspctx/evaluation.hpp"
#include "graspctx/grasp_model.hpp"
#include "training_data.hpp"

namespace graspctx {
namespace {

using testing::fixed_options;
using testing::make_rows;
using testing::normal;
using testing::Rows;
using testing::tiny_descriptor;
using testing::uniform;

GraspModel train(const Rows& rows, const TrainOptions& options = fixed_options()) {
  return train_model(rows.features, rows.labels, rows.groups, options);
}

/// Bytes of a model that was trained on `dimension` columns, whatever its descriptor.
std::vector<std::uint8_t> bytes_of(GraspModel model) {
  model.descriptor.shape_context.angular_bins = static_cast<int>(model.mean.size() / 3);
  model.descriptor.shape_context.radial_bins = 1;
  return model.to_safetensors();
}

double provenance(const GraspModel& model, const std::string& key) {
  return std::stod(model.provenance.at(key));
}

/// The message of the InvalidInput that a call throws; fails if it does not.
template <typename Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  ADD_FAILURE() << "expected InvalidInput";
  return "";
}

struct TemporaryFile {
  explicit TemporaryFile(const std::string& text) {
    static int number = 0;
    path = std::filesystem::temp_directory_path() /
           ("graspctx_test_" + std::to_string(::getpid()) + "_" + std::to_string(number++));
    std::ofstream(path, std::ios::binary) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path); }
  std::filesystem::path path;
};

// ------------------------------------------------------------------------------------ libsvm as reference

/// svm-scale's mapping, as its `-r` file describes it.
struct LibsvmRange {
  double lower = 0, upper = 0;
  std::vector<double> minimum, maximum;
  explicit LibsvmRange(const std::string& text) {
    std::istringstream in(text);
    std::string x;
    in >> x >> lower >> upper;
    EXPECT_EQ(x, "x");
    int index = 0;
    double low = 0, high = 0;
    while (in >> index >> low >> high) {
      minimum.push_back(low);
      maximum.push_back(high);
      EXPECT_EQ(index, static_cast<int>(minimum.size()));
    }
  }
  std::vector<svm_node> row(const FeatureMatrix& features, Eigen::Index row) const {
    std::vector<svm_node> nodes;
    for (std::size_t i = 0; i < minimum.size(); ++i) {
      const double value = features(row, static_cast<Eigen::Index>(i));
      nodes.push_back({static_cast<int>(i) + 1,
                       lower + (upper - lower) * (value - minimum[i]) / (maximum[i] - minimum[i])});
    }
    nodes.push_back({-1, 0});
    return nodes;
  }
};

struct FreeSvm {
  void operator()(svm_model* model) const { svm_free_and_destroy_model(&model); }
};

void compare_with_libsvm(const GraspModel& model, const FeatureMatrix& features) {
  const TemporaryFile file(model.to_libsvm());
  const std::unique_ptr<svm_model, FreeSvm> theirs(svm_load_model(file.path.c_str()));
  ASSERT_NE(theirs, nullptr);
  ASSERT_EQ(svm_check_probability_model(theirs.get()), 1);
  ASSERT_EQ(theirs->label[0], 1);
  ASSERT_EQ(theirs->nSV[0], (model.coefficients.array() > 0).count());
  const LibsvmRange range(model.libsvm_range());
  ASSERT_EQ(range.minimum.size(), static_cast<std::size_t>(features.cols()));

  const Eigen::VectorXd values = model.decision_values(features);
  const Eigen::VectorXd probabilities = model.predict_probability(features);
  double worst_value = 0, worst_probability = 0;
  for (Eigen::Index row = 0; row < features.rows(); ++row) {
    const std::vector<svm_node> nodes = range.row(features, row);
    double value = 0, estimates[2];
    svm_predict_values(theirs.get(), nodes.data(), &value);
    svm_predict_probability(theirs.get(), nodes.data(), estimates);
    worst_value = std::max(worst_value, std::abs(value - values[row]));
    worst_probability = std::max(worst_probability, std::abs(estimates[0] - probabilities[row]));
  }
  std::printf("  against libsvm: %d support vectors, %d rows, max |df| %.2g, max |dP| %.2g\n",
              static_cast<int>(model.coefficients.size()), static_cast<int>(features.rows()), worst_value,
              worst_probability);
  EXPECT_LE(worst_value, 1e-9);
  EXPECT_LE(worst_probability, 1e-5);
}

TEST(GraspModel, ProbabilityAgreesWithLibsvmThroughItsOwnFiles) {
  const GraspModel model = train(make_rows(10, 60, 120, 1));
  compare_with_libsvm(model, make_rows(10, 100, 120, 77).features);
  compare_with_libsvm(model, make_rows(10, 60, 120, 1).features);  // the rows it was trained on
}

TEST(GraspModel, ProbabilityAgreesWithLibsvmForOtherOptions) {
  for (const double svm_c : {0.1, 1000.0}) {
    for (const double relative_gamma : {0.02, 8.0}) {
      const GraspModel model = train(make_rows(6, 50, 6, 3), fixed_options(svm_c, relative_gamma));
      compare_with_libsvm(model, make_rows(4, 50, 6, 4).features);
    }
  }
}

TEST(GraspModel, ProbabilityIsTheSigmoidOfTheDecisionValue) {
  GraspModel model = train(make_rows(6, 50, 6, 3));
  const Rows rows = make_rows(6, 50, 6, 5);
  const Eigen::VectorXd values = model.decision_values(rows.features);
  // A steep sigmoid drives z to ±hundreds: both tails must stay accurate, and nothing may overflow.
  for (const double a : {-2.0, -400.0, -1e8, 300.0}) {
    model.sigmoid_a = a;
    model.sigmoid_b = 0.25;
    const Eigen::VectorXd probabilities = model.predict_probability(rows.features);
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const long double z = static_cast<long double>(a) * values[i] + 0.25L;
      const long double expected = 1 / (1 + std::exp(z));
      EXPECT_GE(probabilities[i], 0);
      EXPECT_LE(probabilities[i], 1);
      const double smallest = std::numeric_limits<double>::min();
      EXPECT_LE(std::abs(probabilities[i] - expected), 1e-12L * expected + smallest) << "z = " << z;
    }
  }
}

TEST(GraspModel, RowsDoNotDependOnTheirNeighbours) {
  const GraspModel model = train(make_rows(6, 50, 6, 3));
  const Rows rows = make_rows(3, 33, 6, 5);
  const Eigen::VectorXd together = model.predict_probability(rows.features);
  for (Eigen::Index i = 0; i < together.size(); ++i) {
    EXPECT_EQ(model.predict_probability(rows.features.row(i))[0], together[i]);
  }
  EXPECT_EQ(model.predict_probability(FeatureMatrix(0, 6)).size(), 0);
}

TEST(GraspModel, RefusesFeaturesItCannotUse) {
  const GraspModel model = train(make_rows(6, 50, 6, 3));
  const std::string width = refusal([&] { model.predict_probability(FeatureMatrix::Zero(2, 7)); });
  EXPECT_NE(width.find("6 columns, got 7"), std::string::npos) << width;
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    FeatureMatrix features = FeatureMatrix::Zero(2, 6);
    features(1, 5) = value;
    EXPECT_THROW(model.predict_probability(features), InvalidInput);
    EXPECT_THROW(model.decision_values(features), InvalidInput);
  }
}

TEST(GraspModel, CheckFindsWhateverIsOutOfRange) {
  GraspModel good = train(make_rows(6, 50, 3, 3));
  good.descriptor = tiny_descriptor();
  ASSERT_NO_THROW(good.check());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refuses = [&](const char* what, const auto& spoil) {
    GraspModel bad = good;
    spoil(bad);
    EXPECT_THROW(bad.check(), InvalidInput) << what;
    EXPECT_THROW(bad.to_safetensors(), InvalidInput) << what;
  };
  refuses("no mean", [](GraspModel& m) { m.mean.resize(0); });
  refuses("short mean", [](GraspModel& m) { m.mean.conservativeResize(2); });
  refuses("short scale", [](GraspModel& m) { m.scale.conservativeResize(2); });
  refuses("zero scale", [](GraspModel& m) { m.scale[1] = 0; });
  refuses("negative scale", [](GraspModel& m) { m.scale[1] = -1; });
  refuses("mean nan", [&](GraspModel& m) { m.mean[0] = static_cast<float>(nan); });
  refuses("C zero", [](GraspModel& m) { m.svm_c = 0; });
  refuses("C huge", [](GraspModel& m) { m.svm_c = 1e300; });
  refuses("C below the coefficients", [](GraspModel& m) { m.svm_c = 1e-9; });
  refuses("gamma negative", [](GraspModel& m) { m.gamma = -1; });
  refuses("gamma nan", [&](GraspModel& m) { m.gamma = nan; });
  refuses("rho inf", [](GraspModel& m) { m.rho = INFINITY; });
  refuses("A nan", [&](GraspModel& m) { m.sigmoid_a = nan; });
  refuses("B inf", [](GraspModel& m) { m.sigmoid_b = -INFINITY; });
  refuses("no vectors", [](GraspModel& m) {
    m.support_vectors.resize(0, 3);
    m.coefficients.resize(0);
  });
  refuses("vectors nan", [&](GraspModel& m) { m.support_vectors(0, 0) = static_cast<float>(nan); });
  refuses("vectors too wide", [](GraspModel& m) { m.support_vectors.resize(m.coefficients.size(), 4); });
  refuses("coefficient missing",
          [](GraspModel& m) { m.coefficients.conservativeResize(m.coefficients.size() - 1); });
  refuses("coefficient zero", [](GraspModel& m) { m.coefficients[0] = 0; });
  refuses("negative first", [](GraspModel& m) { m.coefficients.reverseInPlace(); });
  refuses("descriptor of other size", [](GraspModel& m) { m.descriptor = {}; });
  refuses("descriptor invalid", [](GraspModel& m) { m.descriptor.patch.patch_px = -10; });
  refuses("control character", [](GraspModel& m) { m.name = "mug\x1b[31m"; });
  refuses("empty class", [](GraspModel& m) { m.classes = {""}; });
  good.name = "mug\xff";  // no UTF-8: cannot be written
  EXPECT_THROW(good.to_safetensors(), InvalidInput);
}

// ---------------------------------------------------------------------------------------------- training

TEST(TrainModel, SeparatesWhatNoPlaneCan) {
  const GraspModel model = train(make_rows(20, 60, 12, 1));
  const Rows test = make_rows(20, 60, 12, 2);
  const Eigen::VectorXd p = model.predict_probability(test.features);
  const double area = roc_area({p.begin(), p.end()}, test.labels);
  EXPECT_GT(area, 0.9);
  // What cross-validation promised is what unseen images show.
  EXPECT_NEAR(area, provenance(model, "cross_validation.roc_area"), 0.05);
}

TEST(TrainModel, ImagesAreNeverPartedByTheFolds) {
  // Rows of one image are near copies of each other, and its label is drawn at random: whoever sees one of
  // them knows the others, and nobody who does not knows anything.
  std::mt19937 generator(4);
  Rows rows;
  const int images = 250, copies = 4;
  rows.features.resize(images * copies, 5);
  for (int image = 0; image < images; ++image) {
    Eigen::RowVectorXf signature(5);
    for (float& value : signature) value = static_cast<float>(normal(generator));
    const int label = image < 2 ? image : uniform(generator) < 0.5;
    for (int copy = 0; copy < copies; ++copy) {
      const int row = image * copies + copy;
      for (int i = 0; i < 5; ++i) {
        rows.features(row, i) = signature[i] + 0.01f * static_cast<float>(normal(generator));
      }
      rows.labels.push_back(label);
      rows.groups.push_back(image);
    }
  }
  const TrainOptions options = fixed_options(100, 20);
  const GraspModel grouped = train(rows, options);
  EXPECT_NEAR(provenance(grouped, "cross_validation.roc_area"), 0.5, 0.12);
  const Eigen::VectorXd p = grouped.predict_probability(rows.features);
  EXPECT_LT(p.maxCoeff(), 0.85);  // the sigmoid knows that nothing is known
  EXPECT_GT(p.minCoeff(), 0.15);

  // The same rows with every row an image of its own: the test can tell the difference.
  Rows mixed = rows;
  for (std::size_t i = 0; i < mixed.groups.size(); ++i) mixed.groups[i] = static_cast<int>(i);
  EXPECT_GT(provenance(train(mixed, options), "cross_validation.roc_area"), 0.99);
}

/// Rows whose probability is known: logistic in the squared distance from the origin.
Rows rows_of_known_probability(int groups, std::uint32_t seed, std::vector<double>& probabilities) {
  std::mt19937 generator(seed);
  Rows rows;
  rows.features.resize(groups * 100, 3);
  for (int row = 0; row < rows.features.rows(); ++row) {
    for (int i = 0; i < 3; ++i) rows.features(row, i) = static_cast<float>(normal(generator));
    const double p = 1 / (1 + std::exp(1.5 * (rows.features.row(row).squaredNorm() - 1.0)));
    probabilities.push_back(p);
    rows.labels.push_back(uniform(generator) < p);
    rows.groups.push_back(row / 100);
  }
  return rows;
}

TEST(TrainModel, ProbabilitiesAreCalibratedWhateverShareOfNegativesTheSvmSaw) {
  std::vector<double> ignored, truth;
  const Rows rows = rows_of_known_probability(25, 1, ignored);
  const Rows fresh = rows_of_known_probability(80, 2, truth);
  double prior = 0;
  for (const double p : truth) prior += p / static_cast<double>(truth.size());
  for (const int negatives : {1000, 24, 5}) {
    TrainOptions options = fixed_options(1, 0.5);
    options.max_negatives_per_group = negatives;
    options.max_positives_per_group = 1000;
    const GraspModel model = train(rows, options);
    const Eigen::VectorXd p = model.predict_probability(fresh.features);
    EXPECT_NEAR(p.mean(), prior, 0.02) << negatives;
    EXPECT_LT(expected_calibration_error({p.begin(), p.end()}, fresh.labels), 0.03) << negatives;
    const Eigen::Map<const Eigen::VectorXd> expected(truth.data(), static_cast<Eigen::Index>(truth.size()));
    EXPECT_LT((p - expected).cwiseAbs().mean(), 0.05) << negatives;
    EXPECT_EQ(provenance(model, "training.rows"), 2500);
    if (negatives == 5) {
      const auto positives = provenance(model, "training.positives");
      EXPECT_EQ(provenance(model, "training.rows_of_svm"), positives + 25 * 5);
    }
  }
}

TEST(TrainModel, SameBytesEveryTimeInAnyThread) {
  const Rows rows = make_rows(12, 60, 6, 3);
  TrainOptions options = fixed_options();
  options.svm_c = {1, 10};
  options.max_negatives_per_group = 8;
  const std::vector<std::uint8_t> once = bytes_of(train(rows, options));
  EXPECT_EQ(bytes_of(train(rows, options)), once);
  std::vector<std::uint8_t> there, here;
  std::thread other([&] { there = bytes_of(train(rows, options)); });
  here = bytes_of(train(rows, options));
  other.join();
  EXPECT_EQ(there, once);
  EXPECT_EQ(here, once);
  options.seed = 2;  // other negatives, other folds
  EXPECT_NE(bytes_of(train(rows, options)), once);
}

TEST(TrainModel, OrderOfTheClassesDoesNotMatter) {
  Rows rows = make_rows(12, 60, 6, 3);
  const std::vector<std::uint8_t> bytes = bytes_of(train(rows));
  // Within each class and image the rows keep their order; once all positives come first, once last.
  for (const bool positives_first : {true, false}) {
    std::vector<int> order(rows.labels.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    std::stable_partition(order.begin(), order.end(),
                          [&](int row) { return (rows.labels[row] == 1) == positives_first; });
    Rows sorted = rows;
    for (std::size_t i = 0; i < order.size(); ++i) {
      sorted.features.row(static_cast<Eigen::Index>(i)) = rows.features.row(order[i]);
      sorted.labels[i] = rows.labels[order[i]];
      sorted.groups[i] = rows.groups[order[i]];
    }
    ASSERT_EQ(sorted.labels[0], positives_first);
    EXPECT_EQ(bytes_of(train(sorted)), bytes);
  }
  // Names of the images are only names.
  for (int& group : rows.groups) group = group * 1000 - 5000;
  EXPECT_EQ(bytes_of(train(rows)), bytes);
}

TEST(TrainModel, SwappingTheLabelsMirrorsTheModel) {
  Rows rows = make_rows(12, 60, 6, 3);
  TrainOptions options = fixed_options();
  options.max_negatives_per_group = options.max_positives_per_group = 1000;  // the same rows either way
  const GraspModel model = train(rows, options);
  for (int& label : rows.labels) label = 1 - label;
  const GraspModel mirrored = train(rows, options);
  const FeatureMatrix test = make_rows(3, 60, 6, 9).features;
  const Eigen::VectorXd f = model.decision_values(test), g = mirrored.decision_values(test);
  EXPECT_LT((f + g).cwiseAbs().maxCoeff(), 0.02);  // the solver stops at 1e-3
  EXPECT_GT(f.cwiseAbs().maxCoeff(), 1);
  const Eigen::VectorXd p = model.predict_probability(test), q = mirrored.predict_probability(test);
  EXPECT_LT((p + q - Eigen::VectorXd::Ones(p.size())).cwiseAbs().maxCoeff(), 0.02);
}

TEST(TrainModel, DecisionValuesSatisfyTheOptimumOfTheSvm) {
  const Rows rows = make_rows(10, 40, 6, 3);
  TrainOptions options = fixed_options(2, 1);
  options.max_negatives_per_group = 1000;
  const GraspModel model = train(rows, options);
  // The Karush-Kuhn-Tucker conditions of the C-SVC, up to the solver's tolerance, on the training rows:
  // beyond the margin no support vector, within it at the bound C, and Σ y α = 0.
  EXPECT_NEAR(model.coefficients.sum(), 0, 1e-9);
  const Eigen::VectorXd f = model.decision_values(rows.features);
  int free_vectors = 0;
  for (Eigen::Index row = 0; row < f.size(); ++row) {
    const double y = rows.labels[static_cast<std::size_t>(row)] ? 1 : -1;
    const Eigen::RowVectorXf standardised =
        ((rows.features.row(row) - model.mean.transpose()).array() / model.scale.transpose().array());
    double alpha = 0;
    for (Eigen::Index i = 0; i < model.coefficients.size(); ++i) {
      if ((model.support_vectors.row(i) - standardised).norm() < 1e-4) alpha = y * model.coefficients[i];
    }
    const double margin = y * f[row];
    if (alpha <= 0) {
      EXPECT_GE(margin, 1 - 2e-3);
    } else if (alpha >= model.svm_c) {
      EXPECT_LE(margin, 1 + 2e-3);
    } else {
      ++free_vectors;
      EXPECT_NEAR(margin, 1, 2e-3);
    }
  }
  EXPECT_GT(free_vectors, 10);
}

TEST(TrainModel, TakesTheBestPairOfTheGrid) {
  const Rows rows = make_rows(12, 60, 6, 3);
  TrainOptions grid;
  grid.svm_c = {0.5, 20};
  grid.gamma_times_dimension = {0.01, 0.3, 10};
  const GraspModel chosen = train(rows, grid);
  double best = 0, worst = 1, best_c = 0, best_gamma = 0;
  for (const double svm_c : grid.svm_c) {
    for (const double relative_gamma : grid.gamma_times_dimension) {
      const double score =
          provenance(train(rows, fixed_options(svm_c, relative_gamma)), "cross_validation.average_precision");
      worst = std::min(worst, score);
      if (score > best) {
        best = score;
        best_c = svm_c;
        best_gamma = relative_gamma / 6;
      }
    }
  }
  EXPECT_LT(worst, best - 0.05);  // there was something to choose
  EXPECT_EQ(chosen.svm_c, best_c);
  EXPECT_EQ(chosen.gamma, best_gamma);
  EXPECT_EQ(provenance(chosen, "cross_validation.average_precision"), best);
  EXPECT_EQ(provenance(chosen, "training.c"), best_c);
  // The chosen model does not depend on what else was tried.
  EXPECT_EQ(bytes_of(chosen), bytes_of(train(rows, fixed_options(best_c, best_gamma * 6))));
}

TEST(TrainModel, SearchesOnPartButFitsTheSigmoidOnAllImages) {
  const Rows rows = make_rows(40, 60, 6, 3);
  TrainOptions options;
  options.svm_c = {0.5, 20};
  options.gamma_times_dimension = {0.3};
  options.max_search_rows = 300;  // about eight images
  const GraspModel model = train(rows, options);
  const GraspModel direct = train(rows, fixed_options(model.svm_c, 0.3));
  EXPECT_EQ(bytes_of(model), bytes_of(direct));
}

TEST(TrainModel, FewImagesSuffice) {
  const Rows rows = make_rows(5, 100, 6, 3);
  const GraspModel model = train(rows, TrainOptions{});
  const Rows test = make_rows(20, 60, 6, 2);
  const Eigen::VectorXd p = model.predict_probability(test.features);
  EXPECT_GT(roc_area({p.begin(), p.end()}, test.labels), 0.7);
}

TEST(TrainModel, ImagesWithoutOneClassAreDealtSoThatEveryFoldCanBeTrained) {
  // Positives in two images only, negatives in two others only; the ids make a naive dealing fail.
  Rows rows = make_rows(10, 20, 3, 3);
  for (std::size_t i = 0; i < rows.labels.size(); ++i) {
    const int group = rows.groups[i];
    rows.labels[i] = group != 4 && group != 9;
    if (rows.labels[i] == 0) rows.features.row(static_cast<Eigen::Index>(i)).array() += 5;
  }
  EXPECT_GT(provenance(train(rows), "cross_validation.roc_area"), 0.9);
  for (int& label : rows.labels) label = 1 - label;
  EXPECT_GT(provenance(train(rows), "cross_validation.roc_area"), 0.9);
}

TEST(TrainModel, ConstantColumnsAreHarmless) {
  Rows rows = make_rows(8, 50, 6, 3);
  const GraspModel before = train(rows);
  Rows wider = rows;
  wider.features.conservativeResize(Eigen::NoChange, 8);
  wider.features.col(6).setZero();
  wider.features.col(7).setConstant(0.3f);
  TrainOptions options = fixed_options(10, 8.0 / 6);  // the same γ
  const GraspModel after = train(wider, options);
  Rows test = make_rows(8, 50, 6, 4);
  const Eigen::VectorXd expected = before.decision_values(test.features);
  test.features.conservativeResize(Eigen::NoChange, 8);
  test.features.col(6).setZero();
  test.features.col(7).setConstant(0.3f);
  EXPECT_LT((after.decision_values(test.features) - expected).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(TrainModel, ReportsItsProgress) {
  TrainOptions options;
  options.svm_c = {1, 10};
  options.gamma_times_dimension = {0.5, 1};
  std::vector<double> shares;
  options.progress = [&](double share, const std::string& what) {
    EXPECT_FALSE(what.empty());
    shares.push_back(share);
  };
  const Rows rows = make_rows(12, 60, 6, 3);
  for (const int search_rows : {100000, 300}) {
    shares.clear();
    options.max_search_rows = search_rows;
    train(rows, options);
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    EXPECT_GT(shares.size(), 20u);
    EXPECT_GT(shares.front(), 0);
    EXPECT_DOUBLE_EQ(shares.back(), 1);
  }
  // Whoever watches may stop it.
  options.progress = [](double share, const std::string&) {
    if (share > 0.3) throw std::runtime_error("stop");
  };
  EXPECT_THROW(train(rows, options), std::runtime_error);
}

TEST(TrainModel, SaysWhatItCannotTrainOn) {
  const Rows good = make_rows(6, 20, 3, 3);
  const auto refused = [&](const char* expected, const auto& spoil) {
    Rows bad = good;
    TrainOptions options = fixed_options();
    spoil(bad, options);
    const std::string message = refusal([&] { train(bad, options); });
    EXPECT_NE(message.find(expected), std::string::npos) << message;
  };
  refused("120 rows, got 119", [](Rows& r, TrainOptions&) { r.labels.pop_back(); });
  refused("and 121", [](Rows& r, TrainOptions&) { r.groups.push_back(0); });
  refused("labels must be 0 or 1, got 2", [](Rows& r, TrainOptions&) { r.labels[7] = 2; });
  refused("0 positive of 120", [](Rows& r, TrainOptions&) { r.labels.assign(120, 0); });
  refused("120 positive of 120", [](Rows& r, TrainOptions&) { r.labels.assign(120, 1); });
  refused("finite", [](Rows& r, TrainOptions&) { r.features(3, 1) = NAN; });
  refused("finite", [](Rows& r, TrainOptions&) { r.features(3, 1) = -INFINITY; });
  refused("at least one column", [](Rows& r, TrainOptions&) { r.features.resize(120, 0); });
  refused("fewer groups (3) than folds (5)", [](Rows& r, TrainOptions&) {
    for (int& group : r.groups) group /= 2;
  });
  refused("at least two groups", [](Rows& r, TrainOptions&) {
    for (std::size_t i = 0; i < r.labels.size(); ++i) r.labels[i] = r.groups[i] == 2;
  });
  refused("0 rows", [](Rows& r, TrainOptions&) {
    r.features.resize(0, 3);
    r.labels.clear();
  });
  refused("folds", [](Rows&, TrainOptions& o) { o.folds = 1; });
  refused("svm_c", [](Rows&, TrainOptions& o) { o.svm_c.clear(); });
  refused("svm_c", [](Rows&, TrainOptions& o) { o.svm_c = {1, -1}; });
  refused("gamma_times_dimension", [](Rows&, TrainOptions& o) { o.gamma_times_dimension = {NAN}; });
  refused("max_negatives_per_group", [](Rows&, TrainOptions& o) { o.max_negatives_per_group = 0; });
  refused("max_search_rows", [](Rows&, TrainOptions& o) { o.max_search_rows = 0; });
}

// --------------------------------------------------------------------------------------------- the formats

/// A decimal comma and grouped thousands for everything that asks the locale.
class ForeignLocale {
 public:
  ForeignLocale() : before_(std::locale::global(std::locale(std::locale::classic(), new Comma))) {
    std::setlocale(LC_ALL, "de_DE.UTF-8");  // where it is installed
  }
  ~ForeignLocale() {
    std::locale::global(before_);
    std::setlocale(LC_ALL, "C");
  }

 private:
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  std::locale before_;
};

TEST(GraspModel, FormatsDoNotDependOnTheLocale) {
  const Rows rows = make_rows(8, 50, 3, 3);
  GraspModel model = train(rows);
  model.descriptor = tiny_descriptor();
  const std::vector<std::uint8_t> bytes = model.to_safetensors();
  const std::string libsvm = model.to_libsvm(), range = model.libsvm_range();
  const ForeignLocale foreign;
  std::ostringstream probe;
  probe << 1234.5;
  ASSERT_EQ(probe.str(), "1.234,5");
  GraspModel again = train(rows);
  again.descriptor = tiny_descriptor();
  EXPECT_EQ(again.to_safetensors(), bytes);
  EXPECT_EQ(again.to_libsvm(), libsvm);
  EXPECT_EQ(again.libsvm_range(), range);
  EXPECT_EQ(GraspModel::from_safetensors(bytes.data(), bytes.size()).to_safetensors(), bytes);
}

}  // namespace
}  // namespace graspctx
