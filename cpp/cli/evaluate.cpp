#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "dataset_arguments.hpp"
#include "graspctx/evaluation.hpp"
#include "graspctx/io/dataset_files.hpp"
#include "graspctx/io/model_file.hpp"
#include "graspctx/version.hpp"

namespace graspctx::cli {

namespace {

using Json = nlohmann::ordered_json;

struct EvaluateArguments {
  DatasetArguments dataset;
  std::string model, json;
};

std::string interval_text(const Interval& interval) {
  return "[" + fixed(interval.low, 3) + ", " + fixed(interval.high, 3) + "]";
}

std::string evaluation_table(const std::vector<ClassEvaluation>& rows) {
  Table patches({0},
                {"class", "views", "patches", "label prior", "AP", "AP border ignored", "ROC AUC", "ECE"});
  Table top1({0}, {"class", "views", "no label", "chance", "top-1", "95 %", "label > 2 %", "top-1"});
  for (const ClassEvaluation& row : rows) {
    patches.add({row.class_name, std::to_string(row.views + row.views_without_label),
                 std::to_string(row.patches), fixed(row.label_prior, 3), fixed(row.average_precision, 3),
                 fixed(row.average_precision_border_ignored, 3), fixed(row.roc_area, 3),
                 fixed(row.calibration_error, 3)});
    top1.add({row.class_name, std::to_string(row.views), std::to_string(row.views_without_label),
              fixed(row.top1_chance, 3), fixed(row.top1, 3), interval_text(row.top1_interval),
              std::to_string(row.views_large_label), fixed(row.top1_large_label, 3)});
  }
  return "patches\n" + patches.text() +
         "\nbest patch of each view, and of the views whose label is over 2 % of the object\n" + top1.text();
}

/// JSON has no NaN: what is not defined is null.
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

std::string evaluation_json(const LoadedModel& loaded, const std::vector<ClassEvaluation>& rows) {
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
  const Json document{{"schema", 1},
                      {"graspctx", version},
                      {"model", {{"name", loaded.model.name}, {"sha256", loaded.sha256}}},
                      {"classes", std::move(classes)}};
  return document.dump(2) + "\n";
}

void evaluate(const EvaluateArguments& arguments) {
  check_outputs({arguments.json});
  const LoadedModel loaded = load_model(arguments.model);
  const std::vector<LabelledView> views =
      load_dataset(arguments.dataset.dataset, arguments.dataset.options());
  std::vector<ClassEvaluation> rows;
  naming(arguments.dataset.dataset, [&] { rows = evaluate_model(loaded.model, views); });
  if (arguments.json.empty()) {
    write_outputs({{standard_output, evaluation_table(rows)}});
  } else {
    write_outputs({{arguments.json, evaluation_json(loaded, rows)}});
  }
}

}  // namespace

void add_evaluate(CLI::App& program) {
  CLI::App& command =
      *program.add_subcommand("evaluate", "Measure a model on a labelled data set, with the true masks.");
  const auto arguments = std::make_shared<EvaluateArguments>();
  add_dataset_arguments(command, arguments->dataset);
  command.add_option("--model", arguments->model, "a shipped model or a .safetensors file")
      ->required()
      ->type_name("NAME|FILE");
  command
      .add_option("--json", arguments->json, "write the figures as JSON instead of a table; - prints them")
      ->type_name("FILE|-");
  command.footer(
      std::string(dataset_help) +
      "AP: average precision over patches. ECE: expected calibration error. top-1: share of views whose "
      "most\n"
      "probable patch lies on the label, with its 95 % Wilson interval.\n"
      "Example: graspctx_cli evaluate data/mugs_test --model mug\n"
      "Example: graspctx_cli evaluate annotations/instances_val.json --object-label cup --grasp-label handle "
      "--model mug");
  command.callback([arguments] { evaluate(*arguments); });
}

}  // namespace graspctx::cli
