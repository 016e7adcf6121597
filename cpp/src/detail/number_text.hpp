#pragma once
#include <array>
#include <charconv>
#include <string>

namespace graspctx::detail {

/// The shortest text that reads back as the same number, in any locale.
inline std::string number_text(double value) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// With a fixed number of decimals, in any locale.
inline std::string decimal_text(double value, int decimals) {
  std::array<char, 64> text;
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals);
  return error == std::errc{} ? std::string(text.data(), end) : number_text(value);
}

}  // namespace graspctx::detail
