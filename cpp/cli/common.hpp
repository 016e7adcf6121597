#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "graspctx/camera.hpp"
#include "graspctx/io/atomic_file.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::cli {

/// `--json FILE|-`
inline constexpr const char* standard_output = "-";

/// The command line's words, with `--calibration FILE FILE` as two options: the parser could not tell the
/// second file from an image. A second calibration file is always a .yaml or .yml.
std::vector<std::string> words_of(int argc, char** argv);

/// LEFT RIGHT --calibration FILE [FILE] [--rectified]
struct PairArguments {
  std::string left, right;
  std::vector<std::string> calibration;
  bool rectified = false;
};
void add_pair_arguments(CLI::App& command, PairArguments& arguments);

struct LoadedPair {
  StereoCamera camera;
  cv::Mat left, right;
};
/// Throws InvalidInput naming the file, also if the sizes do not fit each other or the calibration.
LoadedPair load_pair(const PairArguments& arguments);

/// [--cues disparity|plane|colour] [--fixate U,V] [--roi X,Y,WIDTH,HEIGHT] [--table-plane NX,NY,NZ,OFFSET]
/// [--gravity X,Y,Z]
struct SegmentationArguments {
  std::string cues = "colour";
  std::vector<double> fixation_px, table_plane, gravity;
  std::vector<int> roi_px;
};
void add_segmentation_arguments(CLI::App& command, SegmentationArguments& arguments);
/// Throws InvalidInput naming the option if a value is out of range or a pixel lies outside of the image.
SegmentationOptions segmentation_options(const SegmentationArguments& arguments, const cv::Size& image_size);

/// [--threads N]: 1 by default.
void add_threads_argument(CLI::App& command, int& threads);
/// Lets OpenCV use as many threads, but no more than there are processors: asked for more, TBB prints a
/// warning.
void use_threads(int threads);

/// Reads an 8-bit mask that must be of the image's size. Throws InvalidInput naming the file.
cv::Mat load_mask_for(const std::string& file, const cv::Size& image_size);

/// Write all files or none; what goes to "-" is printed once they stand.
void write_outputs(const std::vector<PendingFile>& outputs);
/// check_writable for each that is a file. To be called before anything takes long.
void check_outputs(const std::vector<std::string>& files);

/// ".png" of "a/B.PNG".
std::string lower_extension(const std::string& file);
/// A check for options that name a file to write: wrong usage unless it has one of these extensions.
CLI::Validator has_extension(std::vector<std::string> extensions);

/// Run and let InvalidInput name `subject` (a data set, say) if it does not already.
void naming(const std::string& subject, const std::function<void()>& run);

void print_warnings(const std::vector<std::string>& warnings);

/// A line on stderr that rewrites itself, if stderr is a terminal; otherwise nothing.
class Progress {
 public:
  Progress();
  ~Progress();
  void show(double share, const std::string& what);

 private:
  bool is_terminal_;
  std::string last_;
};

/// Columns of text, aligned; `left_aligned` columns to the left, the others, numbers, to the right.
class Table {
 public:
  Table(std::set<std::size_t> left_aligned, std::vector<std::string> header)
      : left_aligned_(std::move(left_aligned)), rows_{std::move(header)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  std::string text() const;

 private:
  std::set<std::size_t> left_aligned_;
  std::vector<std::vector<std::string>> rows_;
};

/// With a fixed number of decimals, in any locale; "-" for NaN.
std::string fixed(double value, int decimals);

}  // namespace graspctx::cli
