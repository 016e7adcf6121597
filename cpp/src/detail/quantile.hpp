#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace graspctx::detail {

/// The value below which `share` (0 to 1) of the values lie, rounded down to one of them. Not for an empty
/// vector.
template <typename Number>
Number quantile(std::vector<Number> values, double share) {
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// The upper median. Not for an empty vector.
template <typename Number>
Number median(std::vector<Number> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace graspctx::detail
