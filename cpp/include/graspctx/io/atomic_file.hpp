#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "graspctx/export.hpp"

namespace graspctx {

/// A file still to be written.
struct PendingFile {
  std::filesystem::path file;
  std::string bytes;
};

/// Write all or nothing: a temporary file in the same folder, then a rename. What stood there stays if it
/// fails. A symbolic link is followed; what is no regular file (a pipe, a device) is written to directly.
/// Throws InvalidInput naming the file.
GRASPCTX_EXPORT void write_file_atomically(const std::filesystem::path& file, const void* bytes,
                                           std::size_t size);
GRASPCTX_EXPORT void write_file_atomically(const std::filesystem::path& file, const std::string& text);
/// The same for files that belong together: none is renamed before all of them are on the disk.
GRASPCTX_EXPORT void write_files_atomically(const std::vector<PendingFile>& files);
/// Throws InvalidInput naming the file unless it can be written: its folder exists, it is no folder itself,
/// and permissions allow it. To be asked before a long computation.
GRASPCTX_EXPORT void check_writable(const std::filesystem::path& file);
/// The bytes of a file of at most max_bytes. Throws InvalidInput naming the file.
GRASPCTX_EXPORT std::vector<std::uint8_t> read_file(const std::filesystem::path& file,
                                                    std::size_t max_bytes = std::size_t{1} << 30);

}  // namespace graspctx
