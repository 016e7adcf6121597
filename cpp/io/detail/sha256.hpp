#pragma once
#include <cstdint>
#include <string>

namespace graspctx::detail {

/// SHA-256 (FIPS 180-4) in lower-case hexadecimal. No library at hand brings it without OpenSSL's size.
std::string sha256_hex(const std::uint8_t* bytes, std::size_t size);

}  // namespace graspctx::detail
