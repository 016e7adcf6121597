#pragma once
#include <cstdint>
#include <string>

#include "graspctx/error.hpp"

namespace graspctx::detail {

inline constexpr std::uint32_t max_image_side_px = 32767;  // OpenCV's remap addresses pixels with 16 bits
inline constexpr std::uint64_t max_image_pixels = 100'000'000;

inline void check_image_size(std::uint64_t width, std::uint64_t height) {
  if (width == 0 || height == 0 || width > max_image_side_px || height > max_image_side_px ||
      width * height > max_image_pixels) {
    throw InvalidInput("its size is " + std::to_string(width) + "x" + std::to_string(height) +
                       " px, expected sides of 1 to " + std::to_string(max_image_side_px) +
                       " px and at most " + std::to_string(max_image_pixels) + " px in all");
  }
}

}  // namespace graspctx::detail
