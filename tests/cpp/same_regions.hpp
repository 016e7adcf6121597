#pragma once
// Are two regions the same but for the order in which their sums were taken?
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

#include "detail/regions.hpp"

namespace graspctx::testing {

/// All numbers of a struct of doubles.
template <typename Sums>
std::vector<double> numbers_of(const Sums& sums) {
  static_assert(std::is_trivially_copyable_v<Sums> && sizeof(Sums) % sizeof(double) == 0);
  std::vector<double> numbers(sizeof(Sums) / sizeof(double));
  std::memcpy(numbers.data(), &sums, sizeof(Sums));
  return numbers;
}

inline void expect_same_sums(const detail::Region& a, const detail::Region& b) {
  const std::vector<double> x = numbers_of(a.sums), y = numbers_of(b.sums);
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(x[i], y[i], 1e-9 * (1 + std::abs(x[i]))) << "sum " << i;
  }
  EXPECT_EQ(a.heights, b.heights);
  EXPECT_EQ(a.colours, b.colours);
  EXPECT_EQ(a.guessed, b.guessed);
  EXPECT_EQ(a.raised, b.raised);
}

inline void expect_same(const detail::Border& a, const detail::Border& b) {
  const std::vector<double> x = numbers_of(a), y = numbers_of(b);
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(x[i], y[i], 1e-9 * (1 + std::abs(x[i]))) << "number " << i;
  }
}

}  // namespace graspctx::testing
