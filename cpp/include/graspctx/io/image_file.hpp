#pragma once
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "graspctx/export.hpp"

namespace graspctx {

/// Read an 8-bit PNG or JPEG image: CV_8UC3 BGR, or CV_8UC1 if the file is grey (alpha dropped, 16-bit scaled
/// down). Throws InvalidInput, naming the file, if it is missing, unreadable, damaged, truncated or too
/// large.
GRASPCTX_EXPORT cv::Mat read_image(const std::filesystem::path& file);
/// Read an 8-bit single-channel PNG (masks, labels) exactly as stored. Throws InvalidInput otherwise.
GRASPCTX_EXPORT cv::Mat read_mask(const std::filesystem::path& file);
/// Write by way of a temporary file beside it, then rename; the format follows the extension: .png, .jpg,
/// .jpeg. CV_8UC1 or CV_8UC3 BGR.
GRASPCTX_EXPORT void write_image(const std::filesystem::path& file, const cv::Mat& image);
/// The bytes that write_image would write to `file`.
GRASPCTX_EXPORT std::string encode_image(const std::filesystem::path& file, const cv::Mat& image);

}  // namespace graspctx
