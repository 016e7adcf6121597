#include <pybind11/stl.h>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/evaluation.hpp"
#include "options.hpp"

namespace graspctx::python {

namespace {

using Measure = double (*)(const std::vector<double>&, const std::vector<int>&);

std::vector<double> scores_argument(const py::object& scores, const char* name) {
  const Eigen::VectorXd values = doubles_argument(scores, name);
  return {values.begin(), values.end()};
}

void define_measure(py::module_& m, const char* name, const std::string& doc, Measure measure) {
  define(
      m, name, "(scores: " + float64_type + ", labels: " + integer_type + ") -> float", doc,
      [measure](const py::object& scores, const py::object& labels) {
        const std::vector<double> values = scores_argument(scores, "scores");
        const std::vector<int> truth = integers_argument(labels, "labels");
        return without_gil([&] { return measure(values, truth); });
      },
      py::arg("scores"), py::arg("labels"));
}

}  // namespace

void bind_evaluation(py::module_& m) {
  define_measure(
      m, "average_precision",
      "Area under the precision-recall curve by steps; NaN without positives. scores: float64 (M,), "
      "labels: integers (M,), 0 or 1.",
      &average_precision);
  define_measure(
      m, "roc_area",
      "Area under the ROC curve, ties as one half; NaN if one class is missing. scores: float64 (M,), "
      "labels: integers (M,), 0 or 1.",
      &roc_area);
  define(
      m, "expected_calibration_error",
      "(probabilities: " + float64_type + ", labels: " + integer_type + ", bins: int | None = None) -> float",
      "Expected calibration error over equal-width bins of the probability.",
      [](const py::object& probabilities, const py::object& labels, std::optional<int> bins) {
        const std::vector<double> values = scores_argument(probabilities, "probabilities");
        const std::vector<int> truth = integers_argument(labels, "labels");
        return bins ? expected_calibration_error(values, truth, *bins)
                    : expected_calibration_error(values, truth);
      },
      py::arg("probabilities"), py::arg("labels"), py::arg("bins") = py::none());
  m.def(
      "wilson_interval",
      [](int successes, int trials) {
        const Interval interval = wilson_interval(successes, trials);
        return std::pair(interval.low, interval.high);
      },
      py::arg("successes"), py::arg("trials"), "95 % interval (low, high) of a share.");

  py::class_<ClassEvaluation> row(m, "ClassEvaluation", "What a model reaches on the views of one class.");
  row.def_readonly("class_name", &ClassEvaluation::class_name);
  row.def_readonly("views", &ClassEvaluation::views, "With at least one positive patch.");
  row.def_readonly("views_without_label", &ClassEvaluation::views_without_label);
  row.def_readonly("patches", &ClassEvaluation::patches);
  row.def_readonly("label_prior", &ClassEvaluation::label_prior, "Share of positive patches.");
  row.def_readonly("average_precision", &ClassEvaluation::average_precision, "Strict.");
  row.def_readonly("average_precision_border_ignored", &ClassEvaluation::average_precision_border_ignored,
                   "Patches labelled by less than half left out.");
  row.def_readonly("roc_area", &ClassEvaluation::roc_area);
  row.def_readonly("calibration_error", &ClassEvaluation::calibration_error);
  row.def_readonly("top1", &ClassEvaluation::top1, "Share of views whose most probable patch is positive.");
  row.def_property_readonly(
      "top1_interval",
      [](const ClassEvaluation& self) { return std::pair(self.top1_interval.low, self.top1_interval.high); },
      "95 % interval of top1.");
  row.def_readonly("top1_chance", &ClassEvaluation::top1_chance);
  row.def_readonly("top1_large_label", &ClassEvaluation::top1_large_label,
                   "Of the views where the label is over 2 % of the object.");
  row.def_readonly("views_large_label", &ClassEvaluation::views_large_label);

  m.def(
      "evaluate_model",
      [](const LoadedModel& model, const std::vector<LabelledView>& views) {
        return without_gil([&] { return evaluate_model(model.model, views); });
      },
      py::arg("model"), py::arg("views"),
      "Evaluate with the true masks: one row for each class and, if there is more than one, a last row "
      "'all'.");
}

}  // namespace graspctx::python
