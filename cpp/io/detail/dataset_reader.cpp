#include "dataset_reader.hpp"

#include <algorithm>
#include <system_error>

namespace graspctx::detail {

namespace fs = std::filesystem;

void fail(const fs::path& file, const std::string& what) {
  throw InvalidInput(file.string() + ": " + what);
}

std::string size_text(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

std::string joined(const std::vector<std::string>& words, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < words.size() && i < most; ++i) text += (i == 0 ? "" : ", ") + words[i];
  if (words.size() > most) text += ", ...";
  return text;
}

bool is_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

std::vector<fs::path> sorted_entries(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    entries.push_back(entry->path());
  }
  if (error) fail(folder, "cannot be read: " + error.message());
  std::sort(entries.begin(), entries.end());
  return entries;
}

void require_size(const fs::path& file, const cv::Mat& image, const cv::Size& expected,
                  const std::string& like) {
  if (image.size() != expected) {
    fail(file, "is " + size_text(image.size()) + " px, expected " + size_text(expected) + " like " + like);
  }
}

bool is_among(const std::string& word, const std::vector<std::string>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool is_wanted(const std::string& class_name, const DatasetOptions& options) {
  return options.classes.empty() || is_among(class_name, options.classes);
}

bool is_image_wanted(const std::string& image_name, const DatasetOptions& options) {
  return options.images.empty() || is_among(image_name, options.images);
}

std::string no_image_wanted(const DatasetOptions& options) {
  return "holds none of the images asked for, expected " + joined(options.images, 3);
}

fs::path path_inside(const fs::path& folder, const std::string& name, const fs::path& annotation) {
  std::string portable = name;
  std::replace(portable.begin(), portable.end(), '\\', '/');  // annotated on Windows
  const fs::path relative = fs::path(portable).lexically_normal();
  const bool has_drive = portable.size() > 1 && portable[1] == ':';
  const bool has_control = std::any_of(portable.begin(), portable.end(),
                                       [](char c) { return static_cast<unsigned char>(c) < 0x20; });
  if (portable.empty() || relative.is_absolute() || has_drive || has_control ||
      (!relative.empty() && *relative.begin() == "..")) {
    const std::string shown = portable.size() > 80 ? portable.substr(0, 80) + "..." : portable;
    fail(annotation,
         "names the image '" + shown + "', expected a relative path inside of " + folder.string());
  }
  return folder / relative;
}

}  // namespace graspctx::detail
