#include <cmath>

#include "detail/json_values.hpp"
#include "graspctx/io/report_file.hpp"
#include "graspctx/version.hpp"

namespace graspctx {

namespace {

using detail::Json;

/// JSON has no NaN: what is not defined is null.
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json to_json(const Interval& interval) {
  return {number(interval.low), number(interval.high)};
}

Json to_json(const std::vector<ClassEvaluation>& rows) {
  Json classes = Json::array();
  for (const ClassEvaluation& row : rows) {
    classes.push_back({{"class", row.class_name},
                       {"views", row.views},
                       {"views_without_label", row.views_without_label},
                       {"patches", row.patches},
                       {"label_prior", number(row.label_prior)},
                       {"ap", number(row.average_precision)},
                       {"ap_border_ignored", number(row.average_precision_border_ignored)},
                       {"auc", number(row.roc_area)},
                       {"ece", number(row.calibration_error)},
                       {"top1", number(row.top1)},
                       {"top1_low", number(row.top1_interval.low)},
                       {"top1_high", number(row.top1_interval.high)},
                       {"chance", number(row.top1_chance)},
                       {"views_large_label", row.views_large_label},
                       {"top1_large_label", number(row.top1_large_label)}});
  }
  return classes;
}

template <typename Item, typename Convert>
Json array_of(const std::vector<Item>& items, const Convert& convert) {
  Json array = Json::array();
  for (const Item& item : items) array.push_back(convert(item));
  return array;
}

Json curves_json(const EvaluationReport& report) {
  return {
      {"precision_recall", array_of(report.precision_recall,
                                    [](const PrecisionRecallPoint& point) {
                                      return Json{{"threshold", number(point.threshold)},
                                                  {"precision", number(point.precision)},
                                                  {"recall", number(point.recall)}};
                                    })},
      {"calibration", array_of(report.calibration,
                               [](const CalibrationBin& bin) {
                                 return Json{{"low", bin.low},
                                             {"high", bin.high},
                                             {"patches", bin.patches},
                                             {"mean_probability", number(bin.mean_probability)},
                                             {"positive_share", number(bin.positive_share)}};
                               })},
      {"learning_curve", array_of(report.learning_curve,
                                  [](const LearningPoint& point) {
                                    return Json{{"images", point.images},
                                                {"ap", number(point.average_precision)},
                                                {"ap_interval", to_json(point.average_precision_interval)}};
                                  })},
      {"label_shares", array_of(report.label_shares,
                                [](const LabelShareRow& row) {
                                  return Json{{"low", row.low},
                                              {"high", row.high},
                                              {"views", row.views},
                                              {"hits", row.hits},
                                              {"mean_best_probability", number(row.mean_best_probability)}};
                                })},
      {"worst", array_of(report.worst, [](const ViewResult& view) {
         return Json{{"source", view.source},
                     {"class", view.class_name},
                     {"ap", number(view.average_precision)},
                     {"hit", view.hit},
                     {"best_probability", number(view.best_probability)},
                     {"visible_label_share", number(view.visible_label_share)}};
       })}};
}

}  // namespace

std::string evaluation_to_json(const std::string& model_name, const std::string& model_sha256,
                               const std::vector<ClassEvaluation>& rows) {
  return detail::text_of({{"schema", 1},
                          {"graspctx", version},
                          {"model", {{"name", model_name}, {"sha256", model_sha256}}},
                          {"classes", to_json(rows)}},
                         2);
}

std::string report_to_json(const ReportHead& head, const EvaluationReport& report) {
  Json facts = Json::object();
  for (const auto& [name, value] : head.facts) facts[name] = value;
  Json document{{"schema", 1},
                {"graspctx", version},
                {"title", head.title},
                {"facts", std::move(facts)},
                {"images", report.images},
                {"classes", to_json(report.classes)},
                {"intervals",
                 {{"ap", to_json(report.average_precision_interval)},
                  {"ap_border_ignored", to_json(report.average_precision_border_ignored_interval)},
                  {"auc", to_json(report.roc_area_interval)},
                  {"ece", to_json(report.calibration_error_interval)}}}};
  document.update(curves_json(report));
  return detail::text_of(document, 2);
}

}  // namespace graspctx
