#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "commands.hpp"
#include "common.hpp"
#include "graspctx/error.hpp"
#include "graspctx/version.hpp"

namespace {

enum ExitCode { done = 0, internal_error = 1, wrong_usage = 2, bad_input = 3 };

/// An error is one line, whatever a file's name or a library's message holds.
void print_error(const std::string& message) {
  std::string line = "graspctx_cli: " + message;
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  std::cerr << line << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace graspctx;
  CLI::App program("Grasp configurations for unknown objects from a stereo pair, by shape context.",
                   "graspctx_cli");
  program.set_version_flag("--version", std::string("graspctx_cli ") + version);
  program.require_subcommand(1);
  program.footer(
      "Exit codes: 0 done, 1 internal error, 2 wrong usage, 3 bad input.\n"
      "Example: graspctx_cli detect left.png right.png --calibration calib.txt --picture grasps.png");
  cli::add_detect(program);
  cli::add_explain(program);
  cli::add_train(program);
  cli::add_evaluate(program);
  cli::add_segment(program);
  cli::add_describe(program);
  cli::add_models(program);
  cli::add_info(program);
  cli::add_export(program);
  cli::add_check(program);

  try {
    std::vector<std::string> words = cli::words_of(argc, argv);
    std::reverse(words.begin(), words.end());  // CLI11 takes them from the back
    program.parse(std::move(words));
    std::cout.flush();
    if (!std::cout) throw InvalidInput("standard output: cannot be written");
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? done : wrong_usage;  // prints help, version or what is wrong
  } catch (const InvalidInput& error) {
    print_error(error.what());
    return bad_input;
  } catch (const std::exception& error) {
    print_error(std::string("internal error: ") + error.what());
    return internal_error;
  }
  return done;
}
