#include "graspctx/io/image_file.hpp"

#include <algorithm>
#include <string>

#include "detail/jpeg_codec.hpp"
#include "detail/png_codec.hpp"
#include "graspctx/error.hpp"
#include "graspctx/io/atomic_file.hpp"

// libpng and libjpeg are called directly, not by way of OpenCV's imread: that one prints their messages,
// returns half an image for a truncated file, and would bring 150 MB of libraries.

namespace graspctx {

namespace {

template <typename Decode>
cv::Mat decode_naming(const std::filesystem::path& file, Decode decode) {
  try {
    return decode();
  } catch (const InvalidInput& error) {
    throw InvalidInput(file.string() + ": " + error.what());
  }
}

std::vector<std::uint8_t> read_image_file(const std::filesystem::path& file) {
  std::vector<std::uint8_t> bytes = read_file(file);
  if (bytes.empty()) throw InvalidInput(file.string() + ": is empty, expected a PNG or JPEG image");
  return bytes;
}

}  // namespace

cv::Mat read_image(const std::filesystem::path& file) {
  const std::vector<std::uint8_t> bytes = read_image_file(file);
  if (detail::is_png(bytes)) {
    return decode_naming(file, [&] { return detail::decode_png(bytes, detail::PngPixels::image); });
  }
  if (detail::is_jpeg(bytes)) return decode_naming(file, [&] { return detail::decode_jpeg(bytes); });
  throw InvalidInput(file.string() + ": is no image that can be read, expected PNG or JPEG");
}

cv::Mat read_mask(const std::filesystem::path& file) {
  const std::vector<std::uint8_t> bytes = read_image_file(file);
  if (!detail::is_png(bytes)) {
    throw InvalidInput(file.string() + ": is no PNG file, expected an 8-bit single-channel PNG");
  }
  cv::Mat mask = decode_naming(file, [&] { return detail::decode_png(bytes, detail::PngPixels::as_stored); });
  if (mask.type() != CV_8UC1) {
    throw InvalidInput(file.string() + ": has 16 bits a pixel, expected an 8-bit single-channel PNG");
  }
  return mask;
}

void write_image(const std::filesystem::path& file, const cv::Mat& image) {
  write_file_atomically(file, encode_image(file, image));
}

std::string encode_image(const std::filesystem::path& file, const cv::Mat& image) {
  if (image.empty() || (image.type() != CV_8UC1 && image.type() != CV_8UC3)) {
    throw InvalidInput(file.string() + ": only 8-bit images of 1 or 3 channels can be written");
  }
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : char(c); });
  if (extension == ".png") return detail::encode_png(image);
  if (extension == ".jpg" || extension == ".jpeg") return detail::encode_jpeg(image);
  throw InvalidInput(file.string() + ": unknown image format '" + extension +
                     "', expected .png, .jpg or .jpeg");
}

}  // namespace graspctx
