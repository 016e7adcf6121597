#pragma once
#include <CLI/CLI.hpp>

namespace graspctx::cli {

/// Each adds one subcommand to the program; it runs while the command line is parsed. Bad input is reported
/// by InvalidInput, wrong usage that the parser cannot see by CLI::ValidationError.
void add_detect(CLI::App& program);
void add_explain(CLI::App& program);
void add_train(CLI::App& program);
void add_evaluate(CLI::App& program);
void add_segment(CLI::App& program);
void add_describe(CLI::App& program);
void add_models(CLI::App& program);
void add_info(CLI::App& program);
void add_export(CLI::App& program);
void add_check(CLI::App& program);

}  // namespace graspctx::cli
