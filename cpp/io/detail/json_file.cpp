#include "json_file.hpp"

#include <algorithm>
#include <cmath>

#include "graspctx/error.hpp"
#include "graspctx/io/atomic_file.hpp"

namespace graspctx::detail {

namespace {

constexpr int max_depth = 64;

/// A few printable characters for a message.
std::string printable(std::string text, std::size_t longest) {
  if (text.size() > longest) text = text.substr(0, longest) + "...";
  for (char& c : text) {
    if (c < 0x20 || c > 0x7e) c = c == '\n' || c == '\t' || c == '\r' ? ' ' : '?';
  }
  return text;
}

}  // namespace

Json read_json_object(const std::filesystem::path& file, std::size_t max_bytes) {
  const std::vector<std::uint8_t> bytes = read_file(file, max_bytes);
  const auto refuse_depth = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > max_depth) {
      throw InvalidInput(file.string() + ": is nested too deeply, expected at most " +
                         std::to_string(max_depth) + " levels");
    }
    return true;
  };
  Json json;
  try {
    json = Json::parse(bytes.begin(), bytes.end(), refuse_depth);
  } catch (const Json::parse_error& error) {
    const std::size_t at = std::min(bytes.size(), error.byte > 6 ? error.byte - 6 : 0);
    const std::size_t end = std::min(bytes.size(), at + 32);
    throw InvalidInput(file.string() + ": is no valid JSON: at byte " + std::to_string(error.byte) +
                       ", near '" +
                       printable({bytes.begin() + static_cast<std::ptrdiff_t>(at),
                                  bytes.begin() + static_cast<std::ptrdiff_t>(end)},
                                 32) +
                       "'");
  } catch (const Json::exception&) {  // a number that no double holds
    throw InvalidInput(file.string() + ": is no valid JSON: it holds a number out of range");
  }
  if (!json.is_object()) throw InvalidInput(file.string() + ": holds no JSON object");
  return json;
}

const Json* member(const Json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

std::optional<double> finite_number(const Json* value) {
  if (value == nullptr || !value->is_number()) return std::nullopt;
  const double number = value->get<double>();
  return std::isfinite(number) ? std::optional<double>(number) : std::nullopt;
}

std::string short_text(const Json* value) {
  if (value == nullptr) return "missing";
  return printable(value->dump(-1, ' ', true, Json::error_handler_t::replace), 40);
}

}  // namespace graspctx::detail
