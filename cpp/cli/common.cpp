#include "common.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>
#include <limits>
#include <opencv2/core/utility.hpp>

#include "graspctx/error.hpp"
#include "graspctx/io/calibration_file.hpp"
#include "graspctx/io/image_file.hpp"

namespace graspctx::cli {

namespace {

namespace fs = std::filesystem;

std::string size_text(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height) + " px";
}

bool is_yaml(const std::string& file) {
  const std::string extension = lower_extension(file);
  return extension == ".yaml" || extension == ".yml";
}

constexpr int largest_side_px = 32767;

/// CLI::Range would let NaN pass.
CLI::Validator number_within(double least, double most) {
  return CLI::Validator(
      [=](const std::string& word) {
        double value = std::numeric_limits<double>::quiet_NaN();
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        const bool good =
            error == std::errc{} && end == word.data() + word.size() && value >= least && value <= most;
        return good ? std::string()
                    : "'" + word + "' is no number from " + fixed(least, 0) + " to " + fixed(most, 0);
      },
      "");
}

/// Number of characters of UTF-8 text.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

}  // namespace

std::vector<std::string> words_of(int argc, char** argv) {
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    words.emplace_back(argv[i]);
    if (words.back() == "--calibration" && i + 2 < argc && is_yaml(argv[i + 1]) && is_yaml(argv[i + 2])) {
      words.insert(words.end(), {argv[i + 1], "--calibration", argv[i + 2]});
      i += 2;
    }
  }
  return words;
}

void add_pair_arguments(CLI::App& command, PairArguments& arguments) {
  command.add_option("LEFT", arguments.left, "left image, PNG or JPEG")->required();
  command.add_option("RIGHT", arguments.right, "right image, of the same size")->required();
  command
      .add_option("--calibration", arguments.calibration,
                  "a Middlebury calib.txt, or a pair of ROS camera_info YAML files: left, right")
      ->required()
      ->type_name("FILE [FILE]")
      ->allow_extra_args(false)
      ->take_all();
  command.add_flag("--rectified", arguments.rectified,
                   "the images of a camera_info pair are rectified already");
}

LoadedPair load_pair(const PairArguments& arguments) {
  LoadedPair pair;
  pair.camera =
      load_calibration({arguments.calibration.begin(), arguments.calibration.end()}, arguments.rectified);
  pair.left = read_image(arguments.left);
  pair.right = read_image(arguments.right);
  if (pair.right.size() != pair.left.size()) {
    throw InvalidInput(arguments.right + ": is " + size_text(pair.right.size()) + ", expected " +
                       size_text(pair.left.size()) + " like " + arguments.left);
  }
  const cv::Size calibrated(pair.camera.width_px, pair.camera.height_px);
  if (calibrated.area() > 0 && pair.left.size() != calibrated) {
    throw InvalidInput(arguments.left + ": is " + size_text(pair.left.size()) + ", expected " +
                       size_text(calibrated) + " as in " + arguments.calibration.front());
  }
  if (pair.left.type() != pair.right.type()) {
    throw InvalidInput(arguments.right + ": is " + (pair.right.channels() == 1 ? "grey" : "colour") +
                       ", expected the same as " + arguments.left);
  }
  return pair;
}

void add_segmentation_arguments(CLI::App& command, SegmentationArguments& arguments) {
  command
      .add_option("--cues", arguments.cues,
                  "what makes an object; each level adds to the one before: disparity, plane, colour")
      ->check(CLI::IsMember({"disparity", "plane", "colour"}))
      ->type_name("LEVEL")
      ->capture_default_str();
  command
      .add_option("--fixate", arguments.fixation_px, "look at the object at this pixel of the left view only")
      ->type_name("U,V")
      ->delimiter(',')
      ->expected(2)
      ->check(number_within(0, largest_side_px));
  command.add_option("--roi", arguments.roi_px, "look at the object in this box (px) of the left view only")
      ->type_name("X,Y,WIDTH,HEIGHT")
      ->delimiter(',')
      ->expected(4)
      ->check(CLI::Range(0, largest_side_px));
  command
      .add_option("--table-plane", arguments.table_plane,
                  "the table of a fixed rig: unit normal (towards the camera) and offset (m) in the left "
                  "camera's frame, as the JSON's table_plane gives them")
      ->type_name("NX,NY,NZ,OFFSET")
      ->delimiter(',')
      ->expected(4)
      ->check(number_within(-1e6, 1e6));
  command
      .add_option("--gravity", arguments.gravity,
                  "where things fall, in the left camera's frame (x right, y down, z forward): for cameras "
                  "that are turned or look straight down")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->check(number_within(-1e6, 1e6))
      ->excludes("--table-plane");
}

SegmentationOptions segmentation_options(const SegmentationArguments& arguments, const cv::Size& image_size) {
  SegmentationOptions options;
  if (arguments.cues == "disparity") options.cues = CueLevel::disparity;
  if (arguments.cues == "plane") options.cues = CueLevel::plane;
  if (arguments.cues == "colour") options.cues = CueLevel::colour;
  if (const std::vector<int>& box = arguments.roi_px; !box.empty()) {
    options.roi_px = cv::Rect(box[0], box[1], box[2], box[3]);
    if (box[0] + box[2] > image_size.width || box[1] + box[3] > image_size.height) {
      throw InvalidInput("--roi: the box reaches out of the image, expected it within " +
                         size_text(image_size));
    }
    naming("--roi", [&] { options.check(); });
  }
  if (!arguments.fixation_px.empty()) {
    const Eigen::Vector2d pixel(arguments.fixation_px[0], arguments.fixation_px[1]);
    if (pixel.x() > image_size.width - 1 || pixel.y() > image_size.height - 1) {
      throw InvalidInput("--fixate: the pixel lies outside of the image, expected less than " +
                         std::to_string(image_size.width) + "," + std::to_string(image_size.height));
    }
    options.fixation_px = pixel;
    naming("--fixate", [&] { options.check(); });
  }
  if (const std::vector<double>& plane = arguments.table_plane; !plane.empty()) {
    options.table.emplace();
    options.table->normal = {plane[0], plane[1], plane[2]};
    options.table->offset_m = plane[3];
    naming("--table-plane", [&] { options.check(); });
  }
  if (const std::vector<double>& down = arguments.gravity; !down.empty()) {
    options.gravity = {down[0], down[1], down[2]};
    naming("--gravity", [&] { options.check(); });
  }
  return options;
}

void add_threads_argument(CLI::App& command, int& threads) {
  command.add_option("--threads", threads, "the result is the same for any number")
      ->check(CLI::Range(1, 256))
      ->type_name("N")
      ->capture_default_str();
}

void use_threads(int threads) {
  cv::setNumThreads(std::min(threads, cv::getNumberOfCPUs()));
}

cv::Mat load_mask_for(const std::string& file, const cv::Size& image_size) {
  cv::Mat mask = read_mask(file);
  if (mask.size() != image_size) {
    throw InvalidInput(file + ": is " + size_text(mask.size()) + ", expected " + size_text(image_size) +
                       " like the image");
  }
  return mask;
}

void check_outputs(const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    if (!file.empty() && file != standard_output) check_writable(file);
  }
}

void write_outputs(const std::vector<PendingFile>& outputs) {
  std::vector<PendingFile> files;
  for (const PendingFile& output : outputs) {
    if (output.file != standard_output) files.push_back(output);
  }
  write_files_atomically(files);
  for (const PendingFile& output : outputs) {
    if (output.file == standard_output) std::cout << output.bytes;
  }
}

std::string lower_extension(const std::string& file) {
  std::string extension = fs::path(file).extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

CLI::Validator has_extension(std::vector<std::string> extensions) {
  std::string expected;
  for (const std::string& extension : extensions) expected += (expected.empty() ? "" : ", ") + extension;
  return CLI::Validator(
      [extensions = std::move(extensions), expected](const std::string& file) {
        const bool known =
            std::find(extensions.begin(), extensions.end(), lower_extension(file)) != extensions.end();
        return known ? std::string() : file + ": unknown extension, expected " + expected;
      },
      "");
}

void naming(const std::string& subject, const std::function<void()>& run) {
  try {
    run();
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    if (message.find(subject) != std::string::npos) throw;
    throw InvalidInput(subject + ": " + message);
  }
}

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) std::cerr << "graspctx_cli: warning: " << warning << '\n';
}

Progress::Progress() : is_terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (!last_.empty()) std::cerr << "\r\x1b[K" << std::flush;
}

void Progress::show(double share, const std::string& what) {
  if (!is_terminal_) return;
  const std::string line = fixed(100 * share, 0) + " %  " + what;
  if (line == last_) return;
  last_ = line;
  std::cerr << "\r\x1b[K" << line << std::flush;
}

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width_of(row[i]));
  }
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string blanks(widths[i] - width_of(row[i]), ' ');
      line += (i == 0 ? "" : "  ") + (left_aligned_.count(i) ? row[i] + blanks : blanks + row[i]);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  }
  return text;
}

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  char buffer[64];
  const auto [end, error] =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  return error == std::errc{} ? std::string(buffer, end) : "-";
}

}  // namespace graspctx::cli
