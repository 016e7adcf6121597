#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "graspctx/error.hpp"

namespace graspctx::detail {

/// What is wrong with a data set: the first problem is thrown when it is loaded, all are gathered when it is
/// checked. So a reader is written once, and goes on where it can.
class Problems {
 public:
  /// Throws InvalidInput at the first.
  Problems() : is_gathering_(false) {}
  /// Keeps the first max_kept and counts the others.
  explicit Problems(std::size_t max_kept) : is_gathering_(true), max_kept_(max_kept) {}

  bool is_gathering() const { return is_gathering_; }
  std::size_t count() const { return count_; }
  std::vector<std::string> take() { return std::move(lines_); }

  void add(const std::string& line) {
    if (!is_gathering_) throw InvalidInput(line);
    if (count_++ < max_kept_) lines_.push_back(line);
  }
  void add(const std::filesystem::path& file, const std::string& what) { add(file.string() + ": " + what); }

  /// Runs a check that throws InvalidInput; false if it did.
  template <typename Check>
  bool collect(Check check) {
    try {
      check();
      return true;
    } catch (const InvalidInput& error) {
      add(error.what());
      return false;
    }
  }

 private:
  bool is_gathering_;
  std::size_t max_kept_ = 0, count_ = 0;
  std::vector<std::string> lines_;
};

}  // namespace graspctx::detail
