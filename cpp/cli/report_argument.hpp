#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "graspctx/dataset.hpp"
#include "graspctx/evaluation_report.hpp"
#include "graspctx/io/report_file.hpp"

namespace graspctx::cli {

/// [--report FILE.html|FILE.json]
void add_report_argument(CLI::App& command, std::string& report);

/// The report as JSON or HTML, by the extension of its file.
std::string report_text(const std::string& file, const ReportHead& head, const EvaluationReport& report);

/// A view's name within its data set: "scene_000012/left".
std::string short_source(const std::string& source, const std::string& dataset);

}  // namespace graspctx::cli
