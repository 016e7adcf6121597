#pragma once
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace graspctx::detail {

using Json = nlohmann::json;

/// A JSON object from a file. Throws InvalidInput naming the file if it is missing, too large, no JSON, no
/// object, or nested deeper than any data set is: copying and printing a value recurses.
Json read_json_object(const std::filesystem::path& file, std::size_t max_bytes);

/// The member of an object; null if it is none or has no such member.
const Json* member(const Json& object, const char* key);

/// A finite number that a double holds; nothing otherwise.
std::optional<double> finite_number(const Json* value);

/// A short piece of a value for a message.
std::string short_text(const Json* value);

}  // namespace graspctx::detail
