#include "graspctx/io/npy.hpp"

#include <cstdint>
#include <cstring>
#include <string>

#include "graspctx/io/atomic_file.hpp"

namespace graspctx {

void write_npy(const std::filesystem::path& file, const FeatureMatrix& matrix) {
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(matrix.rows()) +
                       ", " + std::to_string(matrix.cols()) + "), }";
  // Magic (6), version (2), length of the header (2), header: the data starts at a multiple of 64 bytes.
  const std::size_t preamble = 10;
  while ((preamble + header.size() + 1) % 64 != 0) header += ' ';
  header += '\n';

  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size() & 0xff);
  bytes += static_cast<char>(header.size() >> 8);
  bytes += header;
  bytes.reserve(bytes.size() + 4 * static_cast<std::size_t>(matrix.size()));
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    std::uint32_t bits;
    std::memcpy(&bits, matrix.data() + i, sizeof bits);
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((bits >> shift) & 0xff);
  }
  write_file_atomically(file, bytes);
}

}  // namespace graspctx
