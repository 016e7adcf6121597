#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "graspctx/export.hpp"
#include "graspctx/grasp_model.hpp"

namespace graspctx {

struct LoadedModel {
  GraspModel model;
  std::string sha256;  // of the file's bytes, hexadecimal
};

/// Load a model from a .safetensors file, or a shipped model by name (mug, pencil, …). Shipped models are
/// looked for in `folders`, then in the installed data folder. Throws InvalidInput naming the file.
GRASPCTX_EXPORT LoadedModel load_model(const std::string& name_or_file,
                                       const std::vector<std::filesystem::path>& folders = {});
GRASPCTX_EXPORT void save_model(const GraspModel& model, const std::filesystem::path& file);
/// Shipped models: their files, sorted by name.
GRASPCTX_EXPORT std::vector<std::filesystem::path> shipped_models(
    const std::vector<std::filesystem::path>& folders = {});

}  // namespace graspctx
