#include "jpeg_codec.hpp"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

// clang-format off: jpeglib.h needs <cstdio> before it, jerror.h needs jpeglib.h
#include <jerror.h>
#include <jpeglib.h>
// clang-format on

#include "graspctx/error.hpp"
#include "image_limits.hpp"

namespace graspctx::detail {

namespace {

/// libjpeg's error manager with a way out. As with libpng: whatever has a destructor lives outside of the
/// functions that may be jumped out of.
struct ErrorManager {
  jpeg_error_mgr base;  // first: libjpeg hands out a pointer to it
  std::jmp_buf way_out;
  char message[JMSG_LENGTH_MAX];
};

[[noreturn]] void on_error(j_common_ptr codec) {
  auto* manager = reinterpret_cast<ErrorManager*>(codec->err);
  codec->err->format_message(codec, manager->message);
  std::longjmp(manager->way_out, 1);
}

void on_message(j_common_ptr codec, int level) {
  if (level >= 0) return;  // a trace
  switch (codec->err->msg_code) {
    // Warnings that leave no wrong pixel: webcams are known for stray bytes between segments.
    case JWRN_EXTRANEOUS_DATA:
    case JWRN_ADOBE_XFORM:
    case JWRN_JFIF_MAJOR:
      return;
    default:
      on_error(codec);
  }
}

void on_output(j_common_ptr) {}  // libjpeg would print

jpeg_error_mgr* make_silent(ErrorManager* manager) {
  jpeg_std_error(&manager->base);
  manager->base.error_exit = [](j_common_ptr codec) { on_error(codec); };
  manager->base.emit_message = on_message;
  manager->base.output_message = on_output;
  manager->message[0] = '\0';
  return &manager->base;
}

struct Decoder {
  jpeg_decompress_struct codec{};
  ErrorManager errors{};
  ~Decoder() { jpeg_destroy_decompress(&codec); }
};

bool read_header(Decoder* decoder, const std::uint8_t* bytes, std::size_t size) {
  decoder->codec.err = make_silent(&decoder->errors);
  if (setjmp(decoder->errors.way_out)) return false;
  jpeg_create_decompress(&decoder->codec);
  jpeg_mem_src(&decoder->codec, bytes, size);
  jpeg_read_header(&decoder->codec, TRUE);
  return true;
}

bool read_pixels(Decoder* decoder, JSAMPARRAY rows) {
  if (setjmp(decoder->errors.way_out)) return false;
  jpeg_start_decompress(&decoder->codec);
  while (decoder->codec.output_scanline < decoder->codec.output_height) {
    const JDIMENSION row = decoder->codec.output_scanline;
    jpeg_read_scanlines(&decoder->codec, rows + row, decoder->codec.output_height - row);
  }
  jpeg_finish_decompress(&decoder->codec);  // reads up to the end marker: warns if there is none
  return true;
}

[[noreturn]] void fail(const Decoder& decoder) {
  throw InvalidInput(std::string("the JPEG file is damaged or truncated (") + decoder.errors.message + ")");
}

struct Encoder {
  jpeg_compress_struct codec{};
  ErrorManager errors{};
  unsigned char* bytes = nullptr;  // allocated by libjpeg
  unsigned long size = 0;
  ~Encoder() {
    jpeg_destroy_compress(&codec);
    std::free(bytes);
  }
};

bool write_pixels(Encoder* encoder, JSAMPARRAY rows, int width, int height, int channels) {
  encoder->codec.err = make_silent(&encoder->errors);
  if (setjmp(encoder->errors.way_out)) return false;
  jpeg_create_compress(&encoder->codec);
  jpeg_mem_dest(&encoder->codec, &encoder->bytes, &encoder->size);
  encoder->codec.image_width = static_cast<JDIMENSION>(width);
  encoder->codec.image_height = static_cast<JDIMENSION>(height);
  encoder->codec.input_components = channels;
  encoder->codec.in_color_space = channels == 3 ? JCS_RGB : JCS_GRAYSCALE;
  jpeg_set_defaults(&encoder->codec);
  jpeg_set_quality(&encoder->codec, 95, TRUE);
  jpeg_start_compress(&encoder->codec, TRUE);
  while (encoder->codec.next_scanline < encoder->codec.image_height) {
    const JDIMENSION row = encoder->codec.next_scanline;
    jpeg_write_scanlines(&encoder->codec, rows + row, encoder->codec.image_height - row);
  }
  jpeg_finish_compress(&encoder->codec);
  return true;
}

std::vector<JSAMPROW> row_pointers(const cv::Mat& image) {
  std::vector<JSAMPROW> rows(static_cast<std::size_t>(image.rows));
  for (int v = 0; v < image.rows; ++v) rows[v] = const_cast<JSAMPROW>(image.ptr(v));
  return rows;
}

}  // namespace

bool is_jpeg(const std::vector<std::uint8_t>& bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff;
}

cv::Mat decode_jpeg(const std::vector<std::uint8_t>& bytes) {
  Decoder decoder;
  if (!read_header(&decoder, bytes.data(), bytes.size())) fail(decoder);
  jpeg_decompress_struct& codec = decoder.codec;
  check_image_size(codec.image_width, codec.image_height);
  if (codec.jpeg_color_space == JCS_CMYK || codec.jpeg_color_space == JCS_YCCK) {
    throw InvalidInput("it is a CMYK image, expected grey or colour");
  }
  const bool grey = codec.jpeg_color_space == JCS_GRAYSCALE;
  codec.out_color_space = grey ? JCS_GRAYSCALE : JCS_RGB;
  cv::Mat image(static_cast<int>(codec.image_height), static_cast<int>(codec.image_width),
                grey ? CV_8UC1 : CV_8UC3);
  std::vector<JSAMPROW> rows = row_pointers(image);
  if (!read_pixels(&decoder, rows.data())) fail(decoder);
  if (!grey) cv::cvtColor(image, image, cv::COLOR_RGB2BGR);
  return image;
}

std::string encode_jpeg(const cv::Mat& image) {
  cv::Mat rgb;
  if (image.channels() == 3) {
    cv::cvtColor(image, rgb, cv::COLOR_BGR2RGB);
  } else {
    rgb = image;
  }
  std::vector<JSAMPROW> rows = row_pointers(rgb);
  Encoder encoder;
  if (!write_pixels(&encoder, rows.data(), rgb.cols, rgb.rows, rgb.channels())) {
    throw std::runtime_error(std::string("libjpeg: ") + encoder.errors.message);
  }
  return std::string(reinterpret_cast<const char*>(encoder.bytes), encoder.size);
}

}  // namespace graspctx::detail
