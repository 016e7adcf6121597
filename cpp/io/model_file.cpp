#include "graspctx/io/model_file.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <optional>
#include <system_error>

#include "detail/sha256.hpp"
#include "graspctx/error.hpp"
#include "graspctx/io/atomic_file.hpp"

namespace graspctx {

namespace {

namespace fs = std::filesystem;

constexpr const char* model_extension = ".safetensors";

/// The folder of shipped models beside the library that holds this function (or the program, if that one
/// holds the library); empty if it cannot be told.
fs::path installed_models_folder() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&installed_models_folder), &info) == 0 || !info.dli_fname)
    return {};
  std::error_code error;
  const fs::path library = fs::canonical(info.dli_fname, error);
  if (error) return {};
  return (library.parent_path() / GRASPCTX_MODELS_FROM_LIBRARY).lexically_normal();
}

std::vector<fs::path> models_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension() == model_extension) files.push_back(entry->path());
  }
  return files;
}

/// A name, in contrast to a path: no folder and no extension.
bool is_name(const fs::path& text) {
  return !text.has_parent_path() && !text.has_extension();
}

fs::path find_model(const std::string& name_or_file, const std::vector<fs::path>& folders) {
  if (name_or_file.empty()) throw InvalidInput("model: the name is empty");
  if (!is_name(name_or_file)) return name_or_file;
  std::string names;
  for (const fs::path& file : shipped_models(folders)) {
    if (file.stem() == name_or_file) return file;
    names += (names.empty() ? "" : ", ") + file.stem().string();
  }
  std::error_code error;
  if (fs::is_regular_file(name_or_file, error)) return name_or_file;
  throw InvalidInput("model '" + name_or_file + "': no such file and no shipped model, expected " +
                     (names.empty() ? "a .safetensors file" : "a .safetensors file or one of: " + names));
}

}  // namespace

std::vector<fs::path> shipped_models(const std::vector<fs::path>& folders) {
  std::vector<fs::path> places = folders;
  if (const fs::path installed = installed_models_folder(); !installed.empty()) places.push_back(installed);
  std::vector<fs::path> files;
  for (const fs::path& place : places) {
    for (fs::path& file : models_in(place)) {
      // The same name in an earlier folder goes first.
      const bool known = std::any_of(files.begin(), files.end(),
                                     [&](const fs::path& other) { return other.stem() == file.stem(); });
      if (!known) files.push_back(std::move(file));
    }
  }
  std::sort(files.begin(), files.end(),
            [](const fs::path& a, const fs::path& b) { return a.stem() < b.stem(); });
  return files;
}

LoadedModel load_model(const std::string& name_or_file, const std::vector<fs::path>& folders) {
  const fs::path file = find_model(name_or_file, folders);
  const std::vector<std::uint8_t> bytes = read_file(file);
  try {
    return {GraspModel::from_safetensors(bytes.data(), bytes.size()),
            detail::sha256_hex(bytes.data(), bytes.size())};
  } catch (const InvalidInput& error) {
    throw InvalidInput(file.string() + ": " + error.what());
  }
}

void save_model(const GraspModel& model, const fs::path& file) {
  const std::vector<std::uint8_t> bytes = model.to_safetensors();
  write_file_atomically(file, bytes.data(), bytes.size());
}

}  // namespace graspctx
