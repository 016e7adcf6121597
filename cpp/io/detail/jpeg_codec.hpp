#pragma once
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace graspctx::detail {

bool is_jpeg(const std::vector<std::uint8_t>& bytes);
/// CV_8UC1 if the file is grey, otherwise CV_8UC3 BGR, pixels as stored (an EXIF orientation would turn the
/// image away from its calibration). Throws InvalidInput, without the file's name, if the bytes are no
/// complete, undamaged JPEG file.
cv::Mat decode_jpeg(const std::vector<std::uint8_t>& bytes);
/// CV_8UC1 or CV_8UC3 BGR, at quality 95.
std::string encode_jpeg(const cv::Mat& image);

}  // namespace graspctx::detail
