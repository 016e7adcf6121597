#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "graspctx/io/dataset_files.hpp"

namespace graspctx::cli {

/// DATASET [--format F] [--classes A,B] [--object-label A,B] [--grasp-label A,B]
struct DatasetArguments {
  std::string dataset, format = "detect";
  std::vector<std::string> classes, object_labels, grasp_labels;

  DatasetOptions options() const;
  /// The options as they would be typed, each after a blank; "" if none was given.
  std::string options_text() const;
};
void add_dataset_arguments(CLI::App& command, DatasetArguments& arguments);

/// For the help of each command that takes a data set.
extern const char* const dataset_help;

}  // namespace graspctx::cli
