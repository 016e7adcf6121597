#pragma once
#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace graspctx::detail {

/// A number below n, each as likely: the standard's own distributions differ between libraries.
inline std::uint32_t draw_below(std::mt19937& random, std::uint32_t n) {
  const std::uint64_t range = std::uint64_t{1} << 32;
  const std::uint64_t fair = range - range % n;
  std::uint64_t number = random();
  while (number >= fair) number = random();
  return static_cast<std::uint32_t>(number % n);
}

/// Moves `count` items drawn at random to the front (all: a shuffle).
inline void draw_to_front(std::vector<int>& items, std::size_t count, std::mt19937& random) {
  for (std::size_t i = 0; i < std::min(count, items.size()); ++i) {
    std::swap(items[i], items[i + draw_below(random, static_cast<std::uint32_t>(items.size() - i))]);
  }
}

}  // namespace graspctx::detail
