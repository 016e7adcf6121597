#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>
#include <optional>

#include "commands.hpp"
#include "common.hpp"
#include "dataset_arguments.hpp"
#include "graspctx/dataset.hpp"
#include "graspctx/error.hpp"
#include "graspctx/grasp_model.hpp"
#include "graspctx/io/dataset_files.hpp"
#include "graspctx/io/model_file.hpp"
#include "graspctx/io/report_file.hpp"
#include "graspctx/version.hpp"
#include "report_argument.hpp"

namespace graspctx::cli {

namespace {

namespace fs = std::filesystem;

struct TrainArguments {
  DatasetArguments dataset;
  std::string output, name, base, report;
  std::uint32_t seed = TrainOptions().seed;
  std::optional<std::string> descriptor;  // robust, or the base's
  int max_rows = 0;                       // 0: the default
};

/// The command that makes this model again.
std::string command_text(const TrainArguments& arguments) {
  std::string text = "graspctx_cli train " + arguments.dataset.dataset + " --output " + arguments.output +
                     arguments.dataset.options_text();
  if (!arguments.name.empty()) text += " --name " + arguments.name;
  if (arguments.seed != TrainOptions().seed) text += " --seed " + std::to_string(arguments.seed);
  if (arguments.descriptor) text += " --descriptor " + *arguments.descriptor;
  if (arguments.max_rows > 0) text += " --max-rows " + std::to_string(arguments.max_rows);
  if (!arguments.base.empty()) text += " --base " + arguments.base;
  return text;
}

/// The data set's own account of itself, on one line; only the project's own layout has one.
std::string dataset_header(const fs::path& dataset, DatasetFormat format) {
  const fs::path file = dataset / "dataset.json";
  if (format != DatasetFormat::graspctx) return "";
  const std::vector<std::uint8_t> bytes = read_file(file);
  const auto header = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
  return header.is_discarded() ? "" : header.dump();
}

/// The base's classes and those of the views, sorted.
std::vector<std::string> classes_of(const std::vector<LabelledView>& views,
                                    const std::optional<LoadedModel>& base) {
  std::vector<std::string> classes = base ? base->model.classes : std::vector<std::string>();
  for (const LabelledView& view : views) {
    if (std::find(classes.begin(), classes.end(), view.class_name) == classes.end()) {
      classes.push_back(view.class_name);
    }
  }
  std::sort(classes.begin(), classes.end());
  return classes;
}

/// The options of a training, from the base on if there is one.
TrainOptions train_options(const TrainArguments& arguments, const std::vector<LabelledView>& views,
                           const std::optional<LoadedModel>& base) {
  TrainOptions options = base ? warm_start(base->model) : TrainOptions();
  options.seed = arguments.seed;
  options.image_names = image_names(views);
  if (arguments.max_rows > 0) options.max_rows = arguments.max_rows;
  if (arguments.report.empty()) return options;
  options.learning_curve = {0.125, 0.25, 0.5};
  if (base) options.learning_curve = {0.5};  // every step of it trains on all of the base
  return options;
}

DescriptorOptions descriptor_options(const TrainArguments& arguments,
                                     const std::optional<LoadedModel>& base) {
  if (base && arguments.descriptor) {
    throw InvalidInput("--descriptor " + *arguments.descriptor + ": a model has the descriptor of its base " +
                       arguments.base + ", expected no --descriptor");
  }
  if (base) return base->model.descriptor;
  return arguments.descriptor == "paper" ? DescriptorOptions() : robust_descriptor();
}

std::string training_report(const TrainArguments& arguments, std::vector<LabelledView> views,
                            const TrainingSet& set, const Training& training) {
  const std::string& dataset = arguments.dataset.dataset;
  for (LabelledView& view : views) view.source = short_source(view.source, dataset);
  ReportHead head{"Training of the model " + training.model.name, {{"data set", dataset}}};
  const auto& provenance = training.model.provenance;
  head.facts.emplace_back(
      "images", provenance.at("training.groups") + ", " + std::to_string(views.size()) + " labelled views");
  head.facts.emplace_back("measured on", "the images of each of " + provenance.at("cross_validation.folds") +
                                             " folds, by models that were trained on the others");
  head.facts.emplace_back("SVM", "C " + provenance.at("training.c") + ", gamma " +
                                     provenance.at("training.gamma_times_dimension") + " / dimension, " +
                                     provenance.at("training.support_vectors") + " support vectors");
  if (!arguments.base.empty()) head.facts.emplace_back("base", provenance.at("base.name"));
  return report_text(arguments.report, head, report_training(views, set, training));
}

void train(const TrainArguments& arguments) {
  check_outputs({arguments.output, arguments.report});
  Progress progress;
  progress.show(0, "reading the data set");
  std::optional<LoadedModel> base;
  if (!arguments.base.empty()) base = load_model(arguments.base);
  const DescriptorOptions descriptor = descriptor_options(arguments, base);
  const std::string& dataset = arguments.dataset.dataset;
  DatasetOptions dataset_options = arguments.dataset.options();
  if (dataset_options.format == DatasetFormat::detect) {
    dataset_options.format = detect_dataset_format(dataset);
  }
  const std::vector<LabelledView> views = load_dataset(dataset, dataset_options);
  AugmentOptions augment;
  augment.seed = arguments.seed;
  TrainOptions options = train_options(arguments, views, base);
  // Describing the views takes about a third of the time.
  options.progress = [&](double share, const std::string& what) { progress.show(0.3 + 0.7 * share, what); };

  TrainingSet set;
  Training training;
  naming(dataset, [&] {
    set = build_training_set(views, descriptor, augment,
                             [&](double share) { progress.show(0.3 * share, "describing the views"); });
    training = train_and_validate(set.features, set.labels, set.groups, options);
  });
  GraspModel& model = training.model;
  naming(dataset, [&] {
    FamiliarityOptions familiarity;
    familiarity.seed = arguments.seed;
    model.familiarity = learn_familiarity(set.features, set.views, set.groups, familiarity);
  });
  model.provenance["familiarity.views"] = std::to_string(model.familiarity->views.rows());
  model.provenance["rows"] = std::to_string(set.labels.size());
  model.provenance["positive_rows"] = std::to_string(std::count(set.labels.begin(), set.labels.end(), 1));
  model.name = arguments.name.empty() ? fs::path(arguments.output).stem().string() : arguments.name;
  model.classes = classes_of(views, base);
  model.descriptor = descriptor;
  model.provenance["command"] = command_text(arguments);
  model.provenance["views"] = std::to_string(views.size());
  model.provenance["graspctx"] = version;
  model.provenance["opencv"] = CV_VERSION;
  model.provenance["dataset_format"] = name_of(dataset_options.format);
  if (const std::string header = dataset_header(dataset, dataset_options.format); !header.empty()) {
    model.provenance["dataset"] = header;
  }
  if (base) {
    model.provenance["base.name"] = base->model.name;
    model.provenance["base.sha256"] = base->sha256;
  }
  const std::vector<std::uint8_t> bytes = model.to_safetensors();
  std::vector<PendingFile> outputs{{arguments.output, {bytes.begin(), bytes.end()}}};
  if (!arguments.report.empty()) {
    progress.show(1, "report");
    outputs.push_back({arguments.report, training_report(arguments, views, set, training)});
  }
  write_outputs(outputs);
}

}  // namespace

void add_train(CLI::App& program) {
  CLI::App& command = *program.add_subcommand("train", "Train a model on a labelled data set.");
  const auto arguments = std::make_shared<TrainArguments>();
  add_dataset_arguments(command, arguments->dataset);
  command.add_option("--output", arguments->output, "the model to write: a .safetensors file")
      ->required()
      ->type_name("MODEL");
  command.add_option("--name", arguments->name, "the model's name; by default the file's")->type_name("NAME");
  command.add_option("--seed", arguments->seed, "of the mask augmentation and the folds")
      ->type_name("N")
      ->capture_default_str();
  command
      .add_option(
          "--descriptor", arguments->descriptor,
          "paper: the 120 numbers of Bohg and Kragic; robust: 240, of masks refined by colour and with "
          "the outline counted a second time")
      ->check(CLI::IsMember({"paper", "robust"}))
      ->default_str("robust, or the base's");
  command
      .add_option(
          "--max-rows", arguments->max_rows,
          "patches of all images together that the support vectors are chosen from: more make a better, "
          "larger and slower model")
      ->type_name("N")
      ->check(CLI::Range(10, 1000000))
      ->default_str(std::to_string(TrainOptions().max_rows));
  command
      .add_option("--base", arguments->base,
                  "a shipped model or a .safetensors file to start from: for few images of your own "
                  "(docs/training.md)")
      ->type_name("NAME|FILE");
  add_report_argument(command, arguments->report);
  command.footer(
      std::string(dataset_help) +
      "Families whose grasp regions contradict each other are better trained apart.\n"
      "Example: graspctx_cli train data/mugs --output mug.safetensors --classes mug\n"
      "Example: graspctx_cli train my_mugs --base mug --output my_mug.safetensors --report my_mug.html\n"
      "Example: graspctx_cli train photographs --object-label mug --grasp-label handle --output "
      "mug.safetensors");
  command.callback([arguments] { train(*arguments); });
}

}  // namespace graspctx::cli
