#pragma once
#include <filesystem>

#include "graspctx/export.hpp"
#include "graspctx/shape_context.hpp"

namespace graspctx {

/// Write a matrix as a float32 .npy file (version 1.0, little-endian, C order), atomically.
GRASPCTX_EXPORT void write_npy(const std::filesystem::path& file, const FeatureMatrix& matrix);

}  // namespace graspctx
