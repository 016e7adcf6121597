#pragma once
#include <filesystem>
#include <opencv2/core.hpp>

#include "graspctx/export.hpp"

namespace graspctx {

/// Read an 8-bit image: CV_8UC3 BGR, or CV_8UC1 if the file is grey (alpha dropped, 16-bit scaled down).
/// Throws InvalidInput, naming the file, if it is missing, unreadable, truncated or too large.
GRASPCTX_EXPORT cv::Mat read_image(const std::filesystem::path& file);
/// Read an 8-bit single-channel image (masks, labels) exactly as stored. Throws InvalidInput otherwise.
GRASPCTX_EXPORT cv::Mat read_mask(const std::filesystem::path& file);
/// Write by way of a temporary file beside it, then rename; the format follows the extension.
GRASPCTX_EXPORT void write_image(const std::filesystem::path& file, const cv::Mat& image);

}  // namespace graspctx
