#include "exif.hpp"

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace graspctx::detail {

namespace {

/// The TIFF structure in an EXIF segment; what lies beyond its end reads as 0.
class Tiff {
 public:
  Tiff(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {}
  std::uint32_t number(std::size_t at, std::size_t byte_count) const {
    if (at > size_ || byte_count > size_ - at) return 0;
    const bool is_little_endian = size_ > 0 && bytes_[0] == 'I';
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < byte_count; ++i) {
      value = value << 8 | bytes_[at + (is_little_endian ? byte_count - 1 - i : i)];
    }
    return value;
  }
  /// The orientation in the first directory: entries of 12 bytes, tag first, value at 8.
  int orientation() const {
    const std::uint32_t orientation_tag = 0x0112;
    const std::size_t directory = number(4, 4);
    const std::size_t entries = number(directory, 2);
    for (std::size_t i = 0; i < entries; ++i) {
      const std::size_t entry = directory + 2 + 12 * i;
      if (number(entry, 2) != orientation_tag) continue;
      const auto value = static_cast<int>(number(entry + 8, 2));
      return value >= 1 && value <= 8 ? value : 1;
    }
    return 1;
  }

 private:
  const std::uint8_t* bytes_;
  std::size_t size_;
};

}  // namespace

int exif_orientation(const std::vector<std::uint8_t>& jpeg) {
  const std::uint8_t app1 = 0xe1, start_of_scan = 0xda;
  const std::string_view exif("Exif\0\0", 6);
  std::size_t at = 2;  // after the start of the image: segments of 0xff, kind, length (with itself), content
  while (at + 4 <= jpeg.size() && jpeg[at] == 0xff && jpeg[at + 1] != start_of_scan) {
    const std::size_t length = static_cast<std::size_t>(jpeg[at + 2]) << 8 | jpeg[at + 3];
    if (length < 2 || length > jpeg.size() - at - 2) break;
    const std::uint8_t* content = jpeg.data() + at + 4;
    if (jpeg[at + 1] == app1 && length - 2 > exif.size() && std::equal(exif.begin(), exif.end(), content)) {
      return Tiff(content + exif.size(), length - 2 - exif.size()).orientation();
    }
    at += 2 + length;
  }
  return 1;
}

}  // namespace graspctx::detail
