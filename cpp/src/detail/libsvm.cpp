#include "detail/libsvm.hpp"

#include <libsvm/svm.h>

#include <algorithm>
#include <memory>

#include "graspctx/error.hpp"

namespace graspctx::detail {

namespace {

struct FreeModel {
  void operator()(svm_model* model) const { svm_free_and_destroy_model(&model); }
};

/// libsvm prints its progress unless told otherwise, through one function pointer of the whole process:
/// set it once, so that models can be trained in several threads.
void silence_libsvm() {
  static const bool silent = [] {
    svm_set_print_string_function([](const char*) {});
    return true;
  }();
  static_cast<void>(silent);
}

}  // namespace

SvmSolution solve_c_svc(const FeatureMatrix& features, const std::vector<int>& labels, double svm_c,
                        double gamma) {
  silence_libsvm();
  const int rows = static_cast<int>(features.rows());
  const int dimension = static_cast<int>(features.cols());
  std::vector<svm_node> nodes(static_cast<std::size_t>(rows) * (dimension + 1));
  std::vector<svm_node*> first_nodes(rows);
  std::vector<double> targets(labels.begin(), labels.end());
  for (int row = 0; row < rows; ++row) {
    svm_node* node = nodes.data() + static_cast<std::size_t>(row) * (dimension + 1);
    first_nodes[row] = node;
    for (int i = 0; i < dimension; ++i) *node++ = {i + 1, features(row, i)};
    *node = {-1, 0};  // end of the row
  }
  svm_problem problem{rows, targets.data(), first_nodes.data()};

  svm_parameter parameter{};
  parameter.svm_type = C_SVC;
  parameter.kernel_type = RBF;
  parameter.gamma = gamma;
  parameter.C = svm_c;
  parameter.cache_size = 500;  // MB
  parameter.eps = 1e-3;
  parameter.shrinking = 1;
  parameter.probability = 0;  // libsvm's own probabilities draw from rand() and mix images between folds
  if (const char* wrong = svm_check_parameter(&problem, &parameter)) {
    throw InvalidInput(std::string("training: libsvm refuses the options: ") + wrong);
  }
  const std::unique_ptr<svm_model, FreeModel> model(svm_train(&problem, &parameter));

  // libsvm's first class is that of the first row; its decision value is positive for that class.
  const double sign = model->label[0] == 1 ? 1 : -1;
  std::vector<int> order(model->l);
  for (int i = 0; i < model->l; ++i) order[i] = i;
  std::stable_partition(order.begin(), order.end(), [&](int i) { return sign * model->sv_coef[0][i] > 0; });
  SvmSolution solution;
  solution.rho = sign * model->rho[0];
  solution.coefficients.resize(model->l);
  for (int i = 0; i < model->l; ++i) {
    solution.rows.push_back(model->sv_indices[order[i]] - 1);
    solution.coefficients[i] = sign * model->sv_coef[0][order[i]];
  }
  return solution;
}

std::string libsvm_version_text() {
  return std::to_string(libsvm_version / 100) + "." + std::to_string(libsvm_version % 100);
}

}  // namespace graspctx::detail
