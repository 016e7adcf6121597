#include "png_codec.hpp"

#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>

#include "graspctx/error.hpp"
#include "image_limits.hpp"

namespace graspctx::detail {

namespace {

/// libpng reports errors by longjmp. So the functions that may be jumped out of (read_header, read_pixels)
/// hold plain values only; whatever has a destructor lives in their callers.
struct Reader {
  const std::uint8_t* bytes;
  std::size_t size;
  std::size_t position;
  char message[128];
  png_structp png;
  png_infop info;

  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
};

void on_error(png_structp png, png_const_charp message) {
  auto* reader = static_cast<Reader*>(png_get_error_ptr(png));
  std::snprintf(reader->message, sizeof reader->message, "%s", message);
  std::longjmp(png_jmpbuf(png), 1);
}

// libpng would print its warnings. They concern colour profiles and other things that are not read here.
void on_warning(png_structp, png_const_charp) {}

void read_bytes(png_structp png, png_bytep target, std::size_t count) {
  auto* reader = static_cast<Reader*>(png_get_io_ptr(png));
  if (count > reader->size - reader->position) png_error(png, "it ends too early");
  std::memcpy(target, reader->bytes + reader->position, count);
  reader->position += count;
}

bool read_header(Reader* reader) {
  if (setjmp(png_jmpbuf(reader->png))) return false;
  png_set_read_fn(reader->png, reader, read_bytes);
  // A wrong checksum means a damaged file, whichever part of it was hit.
  png_set_crc_action(reader->png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  png_set_user_limits(reader->png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // check_image_size says it better
  png_read_info(reader->png, reader->info);
  return true;
}

bool set_transformations(Reader* reader, PngPixels pixels) {
  if (setjmp(png_jmpbuf(reader->png))) return false;
  if (pixels == PngPixels::image) {
    png_set_expand(reader->png);
    png_set_scale_16(reader->png);
    png_set_strip_alpha(reader->png);
    png_set_bgr(reader->png);
  } else {
    png_set_packing(reader->png);  // 1, 2 and 4 bits: one byte for each pixel, the value as it is
    png_set_swap(reader->png);     // 16 bits: the file is big-endian
  }
  png_set_interlace_handling(reader->png);
  png_read_update_info(reader->png, reader->info);
  return true;
}

bool read_pixels(Reader* reader, png_bytepp rows) {
  if (setjmp(png_jmpbuf(reader->png))) return false;
  png_read_image(reader->png, rows);
  png_read_end(reader->png, nullptr);
  return true;
}

[[noreturn]] void fail(const Reader& reader) {
  throw InvalidInput(std::string("the PNG file is damaged or truncated (") + reader.message + ")");
}

std::string describe_colour(int colour_type) {
  switch (colour_type) {
    case PNG_COLOR_TYPE_GRAY:
      return "grey";
    case PNG_COLOR_TYPE_GRAY_ALPHA:
      return "grey with alpha";
    case PNG_COLOR_TYPE_PALETTE:
      return "palette";
    case PNG_COLOR_TYPE_RGB:
      return "colour";
    default:
      return "colour with alpha";
  }
}

}  // namespace

bool is_png(const std::vector<std::uint8_t>& bytes) {
  static const std::uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  return bytes.size() >= sizeof signature && std::memcmp(bytes.data(), signature, sizeof signature) == 0;
}

cv::Mat decode_png(const std::vector<std::uint8_t>& bytes, PngPixels pixels) {
  Reader reader{bytes.data(), bytes.size(), 0, "", nullptr, nullptr};
  reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, on_error, on_warning);
  reader.info = reader.png ? png_create_info_struct(reader.png) : nullptr;
  if (!reader.info) throw std::runtime_error("libpng cannot be initialised");
  if (!read_header(&reader)) fail(reader);

  const png_uint_32 width = png_get_image_width(reader.png, reader.info);
  const png_uint_32 height = png_get_image_height(reader.png, reader.info);
  check_image_size(width, height);
  const int colour_type = png_get_color_type(reader.png, reader.info);
  const int bits = png_get_bit_depth(reader.png, reader.info);
  if (pixels == PngPixels::as_stored && colour_type != PNG_COLOR_TYPE_GRAY) {
    throw InvalidInput("it is a " + describe_colour(colour_type) + " image, expected a single grey channel");
  }
  int type = (colour_type & PNG_COLOR_MASK_COLOR) ? CV_8UC3 : CV_8UC1;
  if (pixels == PngPixels::as_stored && bits == 16) type = CV_16UC1;

  if (!set_transformations(&reader, pixels)) fail(reader);
  cv::Mat image(static_cast<int>(height), static_cast<int>(width), type);
  if (png_get_rowbytes(reader.png, reader.info) != image.step[0]) {
    throw std::runtime_error("libpng: unexpected row size");
  }
  std::vector<png_bytep> rows(height);
  for (png_uint_32 v = 0; v < height; ++v) rows[v] = image.ptr(static_cast<int>(v));
  if (!read_pixels(&reader, rows.data())) fail(reader);
  return image;
}

std::string encode_png(const cv::Mat& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.cols);
  header.height = static_cast<png_uint_32>(image.rows);
  header.format = image.type() == CV_8UC3 ? PNG_FORMAT_BGR : PNG_FORMAT_GRAY;
  const cv::Mat packed = image.isContinuous() ? image : image.clone();
  // The first call asks for an upper bound of the size.
  png_alloc_size_t size = 0;
  if (!png_image_write_to_memory(&header, nullptr, &size, 0, packed.data, 0, nullptr)) {
    throw std::runtime_error(std::string("libpng: ") + header.message);
  }
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, packed.data, 0, nullptr)) {
    throw std::runtime_error(std::string("libpng: ") + header.message);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace graspctx::detail
