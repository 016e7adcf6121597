// The classifier: against libsvm's own prediction, and by the invariants of its training.
#include <gtest/gtest.h>
#include <libsvm/svm.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>

#include "graspctx/error.hpp"
#include "graspctx/evaluation.hpp"
#include "graspctx/grasp_model.hpp"

namespace {

using graspctx::FeatureMatrix;
using graspctx::GraspModel;
using graspctx::InvalidInput;
using graspctx::TrainOptions;

double uniform(std::mt19937& random) {
  return (random() + 0.5) / 4294967296.0;
}
double normal(std::mt19937& random) {
  return std::sqrt(-2 * std::log(uniform(random))) * std::cos(2 * M_PI * uniform(random));
}

struct Data {
  FeatureMatrix features;
  std::vector<int> labels, groups;
};

/// Rows of several images. A row is positive near one of two centres; each image is shifted as a whole.
Data make_data(int groups, int rows_per_group, int dimension, std::uint32_t seed) {
  std::mt19937 random(seed);
  Data data;
  data.features.resize(groups * rows_per_group, dimension);
  for (int row = 0; row < data.features.rows(); ++row) {
    const bool positive = uniform(random) < 0.2;
    const double side = uniform(random) < 0.5 ? 1 : -1;
    for (int i = 0; i < dimension; ++i) {
      const double centre = positive ? (i % 2 ? 1.2 : -1.2) * side : 0;
      // Columns of unlike scale and offset, so that the standardisation matters.
      data.features(row, i) = static_cast<float>((centre + normal(random)) * (0.01 + 0.1 * i) + i);
    }
    data.labels.push_back(positive);
    data.groups.push_back(row / rows_per_group);
  }
  return data;
}

TrainOptions one_candidate() {
  TrainOptions options;
  options.svm_c = {10};
  options.gamma_times_dimension = {1};
  return options;
}

GraspModel small_model(std::uint32_t seed = 1) {
  const Data data = make_data(10, 60, 120, seed);
  GraspModel model = graspctx::train_model(data.features, data.labels, data.groups, one_candidate());
  model.name = "mug";
  model.classes = {"mug", "cup \u00e9"};
  return model;
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
  const GraspModel model = small_model();
  compare_with_libsvm(model, make_data(10, 100, 120, 77).features);
  compare_with_libsvm(model, make_data(10, 60, 120, 1).features);  // the rows it was trained on
}

}  // namespace
