#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "dataset_arguments.hpp"
#include "graspctx/dataset.hpp"
#include "graspctx/grasp_model.hpp"
#include "graspctx/io/dataset_files.hpp"
#include "graspctx/io/model_file.hpp"
#include "graspctx/version.hpp"

namespace graspctx::cli {

namespace {

namespace fs = std::filesystem;

struct TrainArguments {
  DatasetArguments dataset;
  std::string output, name;
  std::uint32_t seed = TrainOptions().seed;
  std::string descriptor = "robust";
};

/// The command that makes this model again.
std::string command_text(const TrainArguments& arguments) {
  std::string text = "graspctx_cli train " + arguments.dataset.dataset + " --output " + arguments.output +
                     arguments.dataset.options_text();
  if (!arguments.name.empty()) text += " --name " + arguments.name;
  if (arguments.seed != TrainOptions().seed) text += " --seed " + std::to_string(arguments.seed);
  if (arguments.descriptor != TrainArguments().descriptor) text += " --descriptor " + arguments.descriptor;
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

std::vector<std::string> classes_of(const std::vector<LabelledView>& views) {
  std::vector<std::string> classes;
  for (const LabelledView& view : views) {
    if (std::find(classes.begin(), classes.end(), view.class_name) == classes.end()) {
      classes.push_back(view.class_name);
    }
  }
  std::sort(classes.begin(), classes.end());
  return classes;
}

void train(const TrainArguments& arguments) {
  check_outputs({arguments.output});
  Progress progress;
  progress.show(0, "reading the data set");
  const std::string& dataset = arguments.dataset.dataset;
  DatasetOptions dataset_options = arguments.dataset.options();
  if (dataset_options.format == DatasetFormat::detect) {
    dataset_options.format = detect_dataset_format(dataset);
  }
  const std::vector<LabelledView> views = load_dataset(dataset, dataset_options);
  const DescriptorOptions descriptor =
      arguments.descriptor == "paper" ? DescriptorOptions() : robust_descriptor();
  AugmentOptions augment;
  augment.seed = arguments.seed;
  TrainOptions options;
  options.seed = arguments.seed;
  options.image_names = image_names(views);
  // Describing the views takes about a third of the time.
  options.progress = [&](double share, const std::string& what) { progress.show(0.3 + 0.7 * share, what); };

  GraspModel model;
  naming(dataset, [&] {
    const TrainingSet set = build_training_set(views, descriptor, augment, [&](double share) {
      progress.show(0.3 * share, "describing the views");
    });
    model = train_model(set.features, set.labels, set.groups, options);
    FamiliarityOptions familiarity;
    familiarity.seed = arguments.seed;
    model.familiarity = learn_familiarity(set.features, set.views, set.groups, familiarity);
    model.provenance["familiarity.views"] = std::to_string(model.familiarity->views.rows());
    model.provenance["rows"] = std::to_string(set.labels.size());
    model.provenance["positive_rows"] = std::to_string(std::count(set.labels.begin(), set.labels.end(), 1));
  });
  model.name = arguments.name.empty() ? fs::path(arguments.output).stem().string() : arguments.name;
  model.classes = classes_of(views);
  model.descriptor = descriptor;
  model.provenance["command"] = command_text(arguments);
  model.provenance["views"] = std::to_string(views.size());
  model.provenance["graspctx"] = version;
  model.provenance["opencv"] = CV_VERSION;
  model.provenance["dataset_format"] = name_of(dataset_options.format);
  if (const std::string header = dataset_header(dataset, dataset_options.format); !header.empty()) {
    model.provenance["dataset"] = header;
  }
  save_model(model, arguments.output);
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
      ->capture_default_str();
  command.footer(std::string(dataset_help) +
                 "Families whose grasp regions contradict each other are better trained apart.\n"
                 "Example: graspctx_cli train data/mugs --output mug.safetensors --classes mug\n"
                 "Example: graspctx_cli train photographs --object-label mug --grasp-label handle --output "
                 "mug.safetensors");
  command.callback([arguments] { train(*arguments); });
}

}  // namespace graspctx::cli
