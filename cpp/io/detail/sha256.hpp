#pragma once
#include <cstdint>
#include <string>

#include "graspctx/export.hpp"

namespace graspctx::detail {

/// SHA-256 (FIPS 180-4) in lower-case hexadecimal. No library at hand brings it without OpenSSL's size.
GRASPCTX_EXPORT std::string sha256_hex(const std::uint8_t* bytes, std::size_t size);

}  // namespace graspctx::detail
