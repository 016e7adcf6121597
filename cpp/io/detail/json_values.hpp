#pragma once
#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "graspctx/segmentation.hpp"

/// What the documents that graspctx writes have in common.
namespace graspctx::detail {

using Json = nlohmann::ordered_json;

/// JSON has no NaN. A result never holds one: if it does, that is a fault of the program, not of the input.
inline double finite(double value) {
  if (!std::isfinite(value)) throw std::logic_error("the result holds a number that is not finite");
  return value;
}

template <typename Derived>
Json to_json(const Eigen::MatrixBase<Derived>& matrix) {
  Json result = Json::array();
  if constexpr (Derived::ColsAtCompileTime == 1) {
    for (Eigen::Index i = 0; i < matrix.size(); ++i) result.push_back(finite(matrix(i)));
  } else {
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
      result.push_back(to_json(matrix.row(i).transpose().eval()));
  }
  return result;
}

inline Json to_json(const cv::Rect& box) {
  return {box.x, box.y, box.width, box.height};
}

inline Json to_json(const TablePlane& table) {
  return {{"normal", to_json(table.normal)}, {"offset_m", finite(table.offset_m)}};
}

inline Json to_json(const std::vector<std::pair<std::string, double>>& timings_ms) {
  Json timings = Json::object();
  for (const auto& [stage, time_ms] : timings_ms) timings[stage] = finite(time_ms);
  return timings;
}

inline std::string text_of(const Json& document, int indent) {
  return document.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace graspctx::detail
