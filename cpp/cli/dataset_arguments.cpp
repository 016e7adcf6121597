#include "dataset_arguments.hpp"

namespace graspctx::cli {

const char* const dataset_help =
    "DATASET is one of these, told apart by what is in it (docs/dataset-format.md):\n"
    "  scenes as python -m graspctx.sim makes them, dataset.json and a folder each\n"
    "  Saxena's layout, img/NAME.png with grasp/graspPriorityWidth_NAME.png\n"
    "  a folder of labelme's JSON files and their images\n"
    "  a COCO file, or the folder that holds it and its images\n"
    "labelme and COCO need --object-label and --grasp-label; `graspctx_cli check DATASET` lists the "
    "labels.\n";

DatasetOptions DatasetArguments::options() const {
  DatasetOptions options;
  for (const DatasetFormat known :
       {DatasetFormat::graspctx, DatasetFormat::saxena, DatasetFormat::labelme, DatasetFormat::coco}) {
    if (format == name_of(known)) options.format = known;
  }
  options.classes = classes;
  options.object_labels = object_labels;
  options.grasp_labels = grasp_labels;
  return options;
}

std::string DatasetArguments::options_text() const {
  std::string text = format == "detect" ? "" : " --format " + format;
  const auto add = [&](const char* option, const std::vector<std::string>& words) {
    for (std::size_t i = 0; i < words.size(); ++i) {
      const bool needs_quotes = words[i].find(' ') != std::string::npos;
      const std::string word = needs_quotes ? "'" + words[i] + "'" : words[i];
      text += i == 0 ? std::string(" ") + option + " " + word : "," + word;
    }
  };
  add("--classes", classes);
  add("--object-label", object_labels);
  add("--grasp-label", grasp_labels);
  return text;
}

void add_dataset_arguments(CLI::App& command, DatasetArguments& arguments) {
  command.add_option("DATASET", arguments.dataset, "folder of the data set, or a COCO file")->required();
  command
      .add_option("--format", arguments.format, "graspctx, saxena, labelme or coco, if not to be detected")
      ->check(CLI::IsMember({"graspctx", "saxena", "labelme", "coco"}))
      ->type_name("NAME");
  const auto add_words = [&](const char* name, std::vector<std::string>& words, const char* description) {
    command.add_option(name, words, description)->delimiter(',')->allow_extra_args(false)->type_name("A,B");
  };
  add_words("--classes", arguments.classes, "object families to take; all by default");
  add_words("--object-label", arguments.object_labels, "labelme, COCO: labels of outlines of objects");
  add_words("--grasp-label", arguments.grasp_labels, "labelme, COCO: labels of outlines of grasp regions");
}

}  // namespace graspctx::cli
