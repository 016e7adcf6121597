#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "dataset_arguments.hpp"
#include "graspctx/evaluation.hpp"
#include "graspctx/io/dataset_files.hpp"
#include "graspctx/io/model_file.hpp"
#include "graspctx/io/report_file.hpp"
#include "report_argument.hpp"

namespace graspctx::cli {

namespace {

struct EvaluateArguments {
  DatasetArguments dataset;
  std::string model, json, report;
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

std::string evaluation_report(const EvaluateArguments& arguments, const LoadedModel& loaded,
                              std::vector<ScoredView> scored) {
  for (ScoredView& view : scored) view.source = short_source(view.source, arguments.dataset.dataset);
  const ReportHead head{
      "Evaluation of the model " + loaded.model.name,
      {{"data set", arguments.dataset.dataset}, {"model", loaded.model.name + ", sha256 " + loaded.sha256}}};
  return report_text(arguments.report, head, report_evaluation(scored));
}

void evaluate(const EvaluateArguments& arguments) {
  check_outputs({arguments.json, arguments.report});
  const LoadedModel loaded = load_model(arguments.model);
  const std::vector<LabelledView> views =
      load_dataset(arguments.dataset.dataset, arguments.dataset.options());
  std::vector<PendingFile> outputs;
  naming(arguments.dataset.dataset, [&] {
    const std::vector<ScoredView> scored = score_views(loaded.model, views);
    const std::vector<ClassEvaluation> rows = evaluate_scores(scored);
    outputs.push_back(
        arguments.json.empty()
            ? PendingFile{standard_output, evaluation_table(rows)}
            : PendingFile{arguments.json, evaluation_to_json(loaded.model.name, loaded.sha256, rows)});
    if (!arguments.report.empty()) {
      outputs.push_back({arguments.report, evaluation_report(arguments, loaded, scored)});
    }
  });
  write_outputs(outputs);
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
  add_report_argument(command, arguments->report);
  command.footer(
      std::string(dataset_help) +
      "AP: average precision over patches. ECE: expected calibration error. top-1: share of views whose "
      "most\n"
      "probable patch lies on the label, with its 95 % Wilson interval.\n"
      "Example: graspctx_cli evaluate data/mugs_test --model mug --report mug.html\n"
      "Example: graspctx_cli evaluate annotations/instances_val.json --object-label cup --grasp-label handle "
      "--model mug");
  command.callback([arguments] { evaluate(*arguments); });
}

}  // namespace graspctx::cli
