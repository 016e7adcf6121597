#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "graspctx/export.hpp"

namespace graspctx {

/// Write all or nothing: a temporary file in the same folder, then a rename. What stood there stays if it
/// fails. Throws InvalidInput naming the file.
GRASPCTX_EXPORT void write_file_atomically(const std::filesystem::path& file, const void* bytes,
                                           std::size_t size);
GRASPCTX_EXPORT void write_file_atomically(const std::filesystem::path& file, const std::string& text);
/// The bytes of a file of at most max_bytes. Throws InvalidInput naming the file.
GRASPCTX_EXPORT std::vector<std::uint8_t> read_file(const std::filesystem::path& file,
                                                    std::size_t max_bytes = std::size_t{1} << 30);

}  // namespace graspctx
