#pragma once
#include <cstddef>
#include <string>

namespace graspctx::detail {

/// No control characters.
bool is_printable(const std::string& text);

constexpr std::size_t max_image_name_bytes = 255;

/// Whether a name of a training image may stand in a model's file, a message or a picture: printable UTF-8,
/// neither empty nor too long, and no absolute path, which would tell about the machine it was made on.
bool is_image_name(const std::string& name);

}  // namespace graspctx::detail
