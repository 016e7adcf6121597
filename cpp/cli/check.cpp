#include <iostream>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "graspctx/error.hpp"
#include "graspctx/io/dataset_files.hpp"

namespace graspctx::cli {

namespace {

void check(const std::string& dataset) {
  const std::vector<std::string> problems = check_dataset(dataset);
  for (const std::string& problem : problems) std::cout << problem << '\n';
  if (!problems.empty()) {
    throw InvalidInput(dataset + ": " + std::to_string(problems.size()) +
                       (problems.size() == 1 ? " problem" : " problems") + ", expected a sound data set");
  }
  std::cout << dataset << ": sound\n";
}

}  // namespace

void add_check(CLI::App& program) {
  CLI::App& command =
      *program.add_subcommand("check", "Check the files of a data set; prints every problem.");
  const auto dataset = std::make_shared<std::string>();
  command.add_option("DATASET", *dataset, "folder of the data set")->required();
  command.footer("Example: graspctx_cli check data/mugs");
  command.callback([dataset] { check(*dataset); });
}

}  // namespace graspctx::cli
