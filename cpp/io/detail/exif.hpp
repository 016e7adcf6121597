#pragma once
#include <cstdint>
#include <vector>

namespace graspctx::detail {

/// How a viewer is to turn the image of a JPEG file, as EXIF counts: 1 = as stored, 3 = upside down, 6 and 8
/// = by a quarter. 1 if the file does not say, or is damaged.
int exif_orientation(const std::vector<std::uint8_t>& jpeg);

}  // namespace graspctx::detail
