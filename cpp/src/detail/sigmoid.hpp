#pragma once
#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace graspctx::detail {

/// 1 / (1 + exp(z)) without overflow, and without losing the digits of small probabilities.
inline double logistic(double z) {
  if (z < 0) return 1 / (1 + std::exp(z));
  const double e = std::exp(-z);
  return e / (1 + e);
}

struct Sigmoid {
  double a = 0, b = 0;  // P = 1 / (1 + exp(a · f + b))
};

/// Platt's sigmoid by the method of Lin, Lin and Weng, "A note on Platt's probabilistic outputs for support
/// vector machines" (2007): Newton's method with backtracking. labels 0 or 1, both present.
Sigmoid fit_sigmoid(const Eigen::VectorXd& decision_values, const std::vector<int>& labels);

}  // namespace graspctx::detail
