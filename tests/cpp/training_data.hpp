#pragma once
// Rows of features of known distribution, for tests of the classifier.
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "graspctx/grasp_model.hpp"
#include "synthetic.hpp"

namespace graspctx::testing {

inline double normal(std::mt19937& generator) {
  const double radius = std::sqrt(-2 * std::log(uniform(generator) + 1e-12));
  return radius * std::cos(2 * CV_PI * uniform(generator));
}

struct Rows {
  FeatureMatrix features;
  std::vector<int> labels, groups;
};

/// Two classes that no plane parts: positive rows (one in five) around two opposite centres, negative ones
/// in between. The columns differ in scale and offset, so that the standardisation matters.
inline Rows make_rows(int groups, int rows_per_group, int dimension, std::uint32_t seed) {
  std::mt19937 generator(seed);
  Rows rows;
  rows.features.resize(groups * rows_per_group, dimension);
  for (int row = 0; row < rows.features.rows(); ++row) {
    const bool positive = uniform(generator) < 0.2;
    const double side = uniform(generator) < 0.5 ? 1 : -1;
    for (int i = 0; i < dimension; ++i) {
      const double centre = positive ? (i % 2 ? 3 : -3) * side / std::sqrt(dimension) : 0;
      rows.features(row, i) = static_cast<float>((centre + normal(generator)) * (0.01 + 0.1 * i) + i);
    }
    rows.labels.push_back(positive);
    rows.groups.push_back(row / rows_per_group);
  }
  return rows;
}

/// One pair of C and γ: no search.
inline TrainOptions fixed_options(double svm_c = 10, double gamma_times_dimension = 1) {
  TrainOptions options;
  options.svm_c = {svm_c};
  options.gamma_times_dimension = {gamma_times_dimension};
  return options;
}

/// A descriptor of three dimensions, so that small models can be stored.
inline DescriptorOptions tiny_descriptor() {
  DescriptorOptions descriptor;
  descriptor.shape_context.angular_bins = 1;
  descriptor.shape_context.radial_bins = 1;
  return descriptor;
}

}  // namespace graspctx::testing
