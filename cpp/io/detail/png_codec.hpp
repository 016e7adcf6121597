#pragma once
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace graspctx::detail {

/// How the pixels of a PNG file are handed out.
enum class PngPixels {
  image,      // CV_8UC1 if the file is grey, otherwise CV_8UC3 BGR; alpha dropped, 16 bits scaled to 8
  as_stored,  // grey without alpha only, values as stored: CV_8UC1, or CV_16UC1 for 16-bit files
};

bool is_png(const std::vector<std::uint8_t>& bytes);
/// Throws InvalidInput, without the file's name, if the bytes are no complete, undamaged PNG file.
cv::Mat decode_png(const std::vector<std::uint8_t>& bytes, PngPixels pixels);
/// CV_8UC1 or CV_8UC3 BGR.
std::string encode_png(const cv::Mat& image);

}  // namespace graspctx::detail
