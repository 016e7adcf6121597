#include "detail/sigmoid.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace graspctx::detail {

Sigmoid fit_sigmoid(const Eigen::VectorXd& decision_values, const std::vector<int>& labels) {
  const Eigen::Index rows = decision_values.size();
  const double positives = static_cast<double>(std::count(labels.begin(), labels.end(), 1));
  const double negatives = static_cast<double>(rows) - positives;
  // Platt's targets: not quite 0 and 1, so that the optimum is finite where the classes can be parted.
  const double target_positive = (positives + 1) / (positives + 2);
  const double target_negative = 1 / (negatives + 2);

  // The parameters are fitted for values of unit size, where Newton's step is well conditioned.
  const double unit = std::max(decision_values.cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::VectorXd values = decision_values / unit;

  // Negative log likelihood with z = a·f + b: Σ log(1 + exp(z)) − (1 − t)·z.
  const auto loss = [&](const Eigen::Vector2d& ab) {
    double sum = 0;
    for (Eigen::Index i = 0; i < rows; ++i) {
      const double target = labels[i] == 1 ? target_positive : target_negative;
      const double z = ab[0] * values[i] + ab[1];
      sum += std::max(z, 0.0) + std::log1p(std::exp(-std::abs(z))) - (1 - target) * z;
    }
    return sum;
  };

  Eigen::Vector2d ab(0, std::log((negatives + 1) / (positives + 1)));  // the prior alone
  double best = loss(ab);
  for (int iteration = 0; iteration < 100; ++iteration) {
    Eigen::Vector2d gradient(0, 0);
    Eigen::Matrix2d hessian = Eigen::Matrix2d::Identity() * 1e-12;  // never singular
    for (Eigen::Index i = 0; i < rows; ++i) {
      const double target = labels[i] == 1 ? target_positive : target_negative;
      const Eigen::Vector2d dz(values[i], 1);
      const double p = logistic(ab[0] * values[i] + ab[1]);
      gradient += (target - p) * dz;
      hessian += p * (1 - p) * dz * dz.transpose();
    }
    if (gradient.cwiseAbs().maxCoeff() < 1e-9 * static_cast<double>(rows)) break;
    const Eigen::Vector2d direction = -hessian.ldlt().solve(gradient);
    const double slope = gradient.dot(direction);
    double step = 1;
    for (; step > 1e-10; step /= 2) {
      const Eigen::Vector2d candidate = ab + step * direction;
      const double value = loss(candidate);
      if (value < best + 1e-4 * step * slope) {
        ab = candidate;
        best = value;
        break;
      }
    }
    if (step <= 1e-10) break;  // no step gets lower: as good as the rounding allows
  }
  return {ab[0] / unit, ab[1]};
}

}  // namespace graspctx::detail
