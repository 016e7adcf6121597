#include <charconv>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "dataset_arguments.hpp"
#include "graspctx/error.hpp"
#include "graspctx/io/dataset_files.hpp"

namespace graspctx::cli {

namespace {

std::string counted(std::size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

/// At most six digits; an axis has no more to say.
std::string number_text(double value) {
  char buffer[32];
  const auto [end, error] =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 6);
  return error == std::errc{} ? std::string(buffer, end) : "-";
}

std::string summary_text(const DatasetSummary& summary) {
  std::string text;
  if (!summary.classes.empty()) {
    Table classes({0}, {"class", "objects", "views", "no label", "object px", "label px"});
    for (const auto& [name, row] : summary.classes) {
      classes.add({name, std::to_string(row.objects), std::to_string(row.views),
                   std::to_string(row.views_without_label), std::to_string(row.object_px),
                   std::to_string(row.label_px)});
    }
    text += '\n' + classes.text();
  }
  if (!summary.labels.empty()) {
    Table labels({0}, {"label", "outlines"});
    for (const auto& [name, count] : summary.labels) labels.add({name, std::to_string(count)});
    text += '\n' + labels.text();
  }
  if (!summary.axes.empty()) {
    Table axes({0, 1}, {"axis", "value", "scenes"});
    for (const auto& [axis, values] : summary.axes) {
      for (const auto& [value, count] : values.scenes_of) axes.add({axis, value, std::to_string(count)});
      if (values.numbers == 0) continue;
      axes.add({axis, number_text(values.lowest) + " to " + number_text(values.highest),
                std::to_string(values.numbers)});
    }
    text += '\n' + axes.text();
  }
  return text;
}

/// A problem is one line, whatever a file's name holds.
std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

void check(const DatasetArguments& arguments) {
  const DatasetReport report = check_dataset(arguments.dataset, arguments.options());
  for (const std::string& problem : report.problems) std::cout << one_line(problem) << '\n';
  if (report.problem_count > report.problems.size()) {
    std::cout << "... and " << report.problem_count - report.problems.size() << " more\n";
  }
  if (report.problem_count > 0) {
    throw InvalidInput(arguments.dataset + ": " + counted(report.problem_count, "problem") +
                       ", expected a sound data set; first " + report.problems.front());
  }
  const DatasetSummary& summary = report.summary;
  std::cout << arguments.dataset << ": sound, layout " << name_of(summary.format) << ", ";
  if (summary.format == DatasetFormat::graspctx) {
    std::cout << counted(static_cast<std::size_t>(summary.scenes), "scene") << ", ";
  }
  std::cout << counted(static_cast<std::size_t>(summary.images), "image") << '\n' << summary_text(summary);
}

}  // namespace

void add_check(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "check", "Check every file of a data set; prints all problems, or what it holds.");
  const auto arguments = std::make_shared<DatasetArguments>();
  add_dataset_arguments(command, *arguments);
  command.footer(std::string(dataset_help) +
                 "Problems go to standard output, one a line: file, what is wrong, what was expected.\n"
                 "Example: graspctx_cli check data/mugs\n"
                 "Example: graspctx_cli check photographs --object-label mug --grasp-label handle");
  command.callback([arguments] { check(*arguments); });
}

}  // namespace graspctx::cli
