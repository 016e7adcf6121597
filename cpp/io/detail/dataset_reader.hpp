#pragma once
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "graspctx/dataset.hpp"
#include "graspctx/io/dataset_files.hpp"
#include "problems.hpp"

namespace graspctx::detail {

/// What a reader is asked for, and where its findings go: views one by one, since a checked data set may be
/// larger than the memory.
struct Reading {
  const DatasetOptions& options;
  Problems& problems;
  DatasetSummary& summary;
  std::function<void(LabelledView)> emit;
};

// One for each layout, in a file of its own.
void read_graspctx_dataset(const std::filesystem::path& folder, Reading& reading);
void read_saxena_dataset(const std::filesystem::path& folder, Reading& reading);
void read_labelme_dataset(const std::filesystem::path& folder, Reading& reading);
void read_coco_dataset(const std::filesystem::path& path, Reading& reading);

/// Everything that docs/dataset-format.md demands of the project's own layout; training reads less of it.
void check_graspctx_dataset(const std::filesystem::path& folder, Problems& problems, DatasetSummary& summary);

// ---- shared by the readers ----

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what);
std::string size_text(const cv::Size& size);
/// "a, b, c", cut after so many
std::string joined(const std::vector<std::string>& words, std::size_t most = 20);
bool is_folder(const std::filesystem::path& path);
/// Throws InvalidInput if the folder cannot be read.
std::vector<std::filesystem::path> sorted_entries(const std::filesystem::path& folder);
/// Throws InvalidInput unless the image is of the expected size; `like` says whose size that is.
void require_size(const std::filesystem::path& file, const cv::Mat& image, const cv::Size& expected,
                  const std::string& like = "the left image");
bool is_among(const std::string& word, const std::vector<std::string>& words);
/// No classes asked for: all of them.
bool is_wanted(const std::string& class_name, const DatasetOptions& options);
/// No images asked for: all of them.
bool is_image_wanted(const std::string& image_name, const DatasetOptions& options);
/// What is wrong with a data set that has none of the images asked for.
std::string no_image_wanted(const DatasetOptions& options);
/// The file that an annotation names, for which only a relative path inside of the folder will do: a data set
/// that was sent to you has no business elsewhere on your disk. Throws InvalidInput naming `annotation`.
std::filesystem::path path_inside(const std::filesystem::path& folder, const std::string& name,
                                  const std::filesystem::path& annotation);

}  // namespace graspctx::detail
