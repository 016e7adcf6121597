#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "graspctx/grasp_model.hpp"

namespace graspctx::detail {

/// What libsvm's solver found: which rows are support vectors, positive ones first, and with which weight.
struct SvmSolution {
  std::vector<int> rows;         // (S) of the features
  Eigen::VectorXd coefficients;  // (S) y_i · α_i
  double rho = 0;                // f(x) = Σ coefficient · K(x, s) − ρ is positive for label 1
};

/// C-SVC with the kernel exp(−γ ‖x − y‖²). labels (M) 0 or 1, both present.
SvmSolution solve_c_svc(const FeatureMatrix& features, const std::vector<int>& labels, double svm_c,
                        double gamma);

/// libsvm's own version, "3.24".
std::string libsvm_version_text();

}  // namespace graspctx::detail
