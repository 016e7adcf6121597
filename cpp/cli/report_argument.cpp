#include "report_argument.hpp"

#include <filesystem>

#include "common.hpp"

namespace graspctx::cli {

void add_report_argument(CLI::App& command, std::string& report) {
  command
      .add_option("--report", report,
                  "write a report with curves, calibration and the worst views, by its extension as HTML or "
                  "JSON (docs/training.md)")
      ->check(has_extension({".html", ".json"}))
      ->type_name("FILE");
}

std::string report_text(const std::string& file, const ReportHead& head, const EvaluationReport& report) {
  const bool as_json = lower_extension(file) == ".json";
  return as_json ? report_to_json(head, report) : report_to_html(head, report);
}

std::string short_source(const std::string& source, const std::string& dataset) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::is_directory(dataset) ? fs::path(dataset) : fs::path(dataset).parent_path();
  const fs::path relative = fs::path(source).lexically_relative(folder);
  const bool inside = !relative.empty() && *relative.begin() != "..";
  return inside ? relative.string() : source;
}

}  // namespace graspctx::cli
