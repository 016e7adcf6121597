#pragma once
#include <string>
#include <utility>
#include <vector>

#include "graspctx/evaluation_report.hpp"
#include "graspctx/export.hpp"

namespace graspctx {

/// What stands above a report: what was measured, and facts by name ("data set", "images", …).
struct ReportHead {
  std::string title;
  std::vector<std::pair<std::string, std::string>> facts;
};

/// Rows of evaluate_scores as JSON, with the hash of the model's file.
GRASPCTX_EXPORT std::string evaluation_to_json(const std::string& model_name, const std::string& model_sha256,
                                               const std::vector<ClassEvaluation>& rows);

/// A report as JSON, schema 1 (docs/training.md). What is not defined is null. The same bytes for the same
/// report.
GRASPCTX_EXPORT std::string report_to_json(const ReportHead& head, const EvaluationReport& report);

/// A report as one HTML file: figures as tables and inline SVG, nothing from outside, no scripts. Names are
/// escaped. The same bytes for the same report.
GRASPCTX_EXPORT std::string report_to_html(const ReportHead& head, const EvaluationReport& report);

}  // namespace graspctx
