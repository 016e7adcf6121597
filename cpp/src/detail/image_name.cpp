#include "detail/image_name.hpp"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace graspctx::detail {

namespace {

bool is_utf8(const std::string& text) {
  try {
    nlohmann::json(text).dump();
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

}  // namespace

bool is_printable(const std::string& text) {
  return std::none_of(text.begin(), text.end(),
                      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

bool is_image_name(const std::string& name) {
  const bool has_drive = name.size() > 1 && name[1] == ':';
  return !name.empty() && name.size() <= max_image_name_bytes && is_printable(name) && is_utf8(name) &&
         !has_drive && !std::filesystem::path(name).is_absolute();
}

}  // namespace graspctx::detail
