#pragma once
#include <opencv2/core.hpp>
#include <string>

#include "graspctx/error.hpp"

namespace graspctx::detail {

inline std::string describe(const cv::Mat& image) {
  if (image.empty()) return "an empty image";
  return std::to_string(image.cols) + "x" + std::to_string(image.rows) + " " + cv::typeToString(image.type());
}

/// An 8-bit BGR or grey image, or InvalidInput.
inline void require_image(const cv::Mat& image, const char* name) {
  if (image.empty() || image.dims != 2 || (image.type() != CV_8UC1 && image.type() != CV_8UC3)) {
    throw InvalidInput(std::string(name) + ": expected an 8-bit image with 1 or 3 channels, got " +
                       describe(image));
  }
}

/// An 8-bit single-channel mask of the given size, or InvalidInput.
inline void require_mask(const cv::Mat& mask, const cv::Size& size, const char* name) {
  if (mask.type() != CV_8UC1 || mask.size() != size) {
    throw InvalidInput(std::string(name) + ": expected an 8-bit single-channel mask of " +
                       std::to_string(size.width) + "x" + std::to_string(size.height) + ", got " +
                       describe(mask));
  }
}

inline void require_option(bool condition, const std::string& message) {
  if (!condition) throw InvalidInput("options: " + message);
}

}  // namespace graspctx::detail
