#include "detail/safetensors.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "graspctx/error.hpp"

namespace graspctx::detail {

namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "tensors are stored as the host holds them");

constexpr std::size_t max_header_bytes = std::size_t{1} << 20;
constexpr std::size_t length_bytes = 8;  // the header's length, u64

[[noreturn]] void fail(const std::string& message) {
  throw InvalidInput("safetensors: " + message);
}

/// Text from the file as it may stand in a message: short and in one line.
std::string shown(const std::string& text) {
  std::string line = "'";
  for (const char c : text.substr(0, 60)) {
    line += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  }
  return line + (text.size() > 60 ? "…'" : "'");
}

/// Bytes of one number, or 0 for a type that is not supported.
std::uint64_t bytes_of(const std::string& dtype) {
  if (dtype == "F64") return 8;
  if (dtype == "F32" || dtype == "I32") return 4;
  if (dtype == "U8") return 1;
  return 0;
}

struct TensorEntry {
  std::optional<std::string> dtype;
  std::optional<std::vector<std::uint64_t>> shape, data_offsets;
};

/// Reads the header event by event instead of building a tree: whatever does not fit the format ends it at
/// once, so that neither depth nor size can grow, and a key given twice is seen.
class HeaderReader final : public nlohmann::json_sax<nlohmann::json> {
 public:
  std::map<std::string, std::string> metadata;
  std::map<std::string, TensorEntry> tensors;

  bool start_object(std::size_t) override {
    if (depth_ == 0) {
      depth_ = 1;
      return true;
    }
    if (depth_ != 1) fail("the header nests an object in " + where());
    depth_ = 2;
    if (!in_metadata()) tensors[entry_];
    return true;
  }

  bool key(string_t& name) override {
    if (depth_ == 1) {
      entry_ = name;
      field_.clear();
      if (!entries_.insert(name).second) fail("the header holds " + shown(name) + " twice");
      if (entries_.size() > 64) fail("the header lists more than 64 entries");
      return true;
    }
    field_ = name;
    if (in_metadata()) {
      if (metadata.count(name) != 0) fail("the metadata holds " + shown(name) + " twice");
      return true;
    }
    const TensorEntry& tensor = tensors[entry_];
    const bool again = (name == "dtype" && tensor.dtype) || (name == "shape" && tensor.shape) ||
                       (name == "data_offsets" && tensor.data_offsets);
    if (again) fail(where() + " is given twice");
    if (name != "dtype" && name != "shape" && name != "data_offsets") {
      fail(where() + " is unknown: expected dtype, shape and data_offsets");
    }
    return true;
  }

  bool end_object() override {
    --depth_;
    return true;
  }

  bool start_array(std::size_t) override {
    if (depth_ != 2 || in_metadata() || (field_ != "shape" && field_ != "data_offsets")) unexpected("a list");
    depth_ = 3;
    list().emplace();
    return true;
  }

  bool end_array() override {
    depth_ = 2;
    return true;
  }

  bool string(string_t& text) override {
    if (depth_ == 2 && in_metadata()) {
      metadata[field_] = text;
    } else if (depth_ == 2 && field_ == "dtype") {
      tensors[entry_].dtype = text;
    } else {
      unexpected("text");
    }
    return true;
  }

  bool number_unsigned(number_unsigned_t value) override {
    if (depth_ != 3) unexpected("a number");
    std::vector<std::uint64_t>& numbers = *list();
    if (numbers.size() == 8) fail(where() + " is a list of more than 8 numbers");
    numbers.push_back(value);
    return true;
  }

  bool number_integer(number_integer_t) override { unexpected("a negative number"); }
  bool number_float(number_float_t, const string_t&) override { unexpected("a fractional or huge number"); }
  bool boolean(bool) override { unexpected("true or false"); }
  bool null() override { unexpected("null"); }
  bool binary(binary_t&) override { unexpected("binary data"); }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception&) override {
    fail("the header is not valid JSON at byte " + std::to_string(position));
  }

 private:
  bool in_metadata() const { return entry_ == "__metadata__"; }
  std::string where() const {
    if (depth_ == 0) return "the header";
    return shown(entry_) + (field_.empty() ? "" : "." + shown(field_));
  }
  std::optional<std::vector<std::uint64_t>>& list() {
    TensorEntry& tensor = tensors[entry_];
    return field_ == "shape" ? tensor.shape : tensor.data_offsets;
  }
  [[noreturn]] void unexpected(const std::string& what) const {
    fail(where() + " holds " + what +
         ": expected an object of tensors (dtype, shape, data_offsets) and of string metadata");
  }

  int depth_ = 0;  // 1: the header, 2: one entry, 3: a list in it
  std::string entry_, field_;
  std::set<std::string> entries_;
};

}  // namespace

std::vector<std::uint8_t> write_safetensors(const Safetensors& content) {
  std::vector<std::pair<std::string, const Tensor*>> ordered;
  for (const auto& [name, tensor] : content.tensors) ordered.emplace_back(name, &tensor);
  std::stable_sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) {
    return bytes_of(a.second->dtype) > bytes_of(b.second->dtype);
  });

  nlohmann::ordered_json header;
  header["__metadata__"] = content.metadata;
  std::size_t offset = 0;
  for (const auto& [name, tensor] : ordered) {
    const std::size_t end = offset + tensor->bytes.size();
    header[name] = {{"dtype", tensor->dtype}, {"shape", tensor->shape}, {"data_offsets", {offset, end}}};
    offset = end;
  }
  std::string text;
  try {
    text = header.dump();
  } catch (const nlohmann::json::exception&) {
    fail("the metadata must be valid UTF-8");
  }
  text.append((8 - text.size() % 8) % 8, ' ');  // so that the tensors are aligned
  if (text.size() > max_header_bytes) {
    fail("the metadata take " + std::to_string(text.size()) + " bytes, more than " +
         std::to_string(max_header_bytes));
  }

  std::vector<std::uint8_t> bytes(length_bytes);
  const std::uint64_t header_bytes = text.size();
  std::memcpy(bytes.data(), &header_bytes, length_bytes);
  bytes.reserve(length_bytes + text.size() + offset);
  bytes.insert(bytes.end(), text.begin(), text.end());
  for (const auto& [name, tensor] : ordered) {
    bytes.insert(bytes.end(), tensor->bytes.begin(), tensor->bytes.end());
  }
  return bytes;
}

Safetensors read_safetensors(const std::uint8_t* bytes, std::size_t size) {
  if (size < length_bytes) {
    fail("the file ends after " + std::to_string(size) + " bytes, within the length of its header");
  }
  std::uint64_t header_bytes = 0;
  std::memcpy(&header_bytes, bytes, length_bytes);
  if (header_bytes > max_header_bytes) {
    fail("a header of " + std::to_string(header_bytes) + " bytes is longer than " +
         std::to_string(max_header_bytes) + ": this is no model file");
  }
  if (header_bytes > size - length_bytes) {
    fail("the file ends within its header: expected " + std::to_string(header_bytes) + " bytes, got " +
         std::to_string(size - length_bytes));
  }
  const char* header = reinterpret_cast<const char*>(bytes) + length_bytes;
  if (header_bytes == 0 || header[0] != '{') fail("the header must be a JSON object");

  HeaderReader reader;
  // Exceptions of the reader pass through; the library's own come as parse_error.
  nlohmann::json::sax_parse(header, header + header_bytes, &reader);

  const std::uint8_t* data = bytes + length_bytes + header_bytes;
  const std::uint64_t data_bytes = size - length_bytes - header_bytes;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> spans;
  for (const auto& [name, entry] : reader.tensors) {
    if (!entry.dtype || !entry.shape || !entry.data_offsets) {
      fail("tensor " + shown(name) + " lacks its dtype, shape or data_offsets");
    }
    const std::uint64_t number_bytes = bytes_of(*entry.dtype);
    if (number_bytes == 0) {
      fail("tensor " + shown(name) + " is of type " + shown(*entry.dtype) + ": expected F64, F32, I32 or U8");
    }
    if (entry.data_offsets->size() != 2) fail("tensor " + shown(name) + " needs two data_offsets");
    const std::uint64_t begin = (*entry.data_offsets)[0], end = (*entry.data_offsets)[1];
    if (begin > end || end > data_bytes) {
      fail("tensor " + shown(name) + " lies at bytes " + std::to_string(begin) + " to " +
           std::to_string(end) + " of " + std::to_string(data_bytes));
    }
    std::uint64_t expected = number_bytes;
    for (const std::uint64_t length : *entry.shape) {
      if (length != 0 && expected > std::numeric_limits<std::uint64_t>::max() / length) {
        fail("the shape of tensor " + shown(name) + " overflows");
      }
      expected *= length;
    }
    if (expected != end - begin) {
      fail("tensor " + shown(name) + " holds " + std::to_string(end - begin) +
           " bytes, but its shape takes " + std::to_string(expected));
    }
    spans.emplace_back(begin, end);
  }

  std::sort(spans.begin(), spans.end());
  std::uint64_t covered = 0;
  for (const auto& [begin, end] : spans) {
    if (begin != covered) fail("the tensors overlap or leave a gap at byte " + std::to_string(covered));
    covered = end;
  }
  if (covered != data_bytes) {
    fail("the tensors cover " + std::to_string(covered) + " of " + std::to_string(data_bytes) + " bytes");
  }

  // Copied only now, when no two tensors can claim the same bytes.
  Safetensors content;
  content.metadata = std::move(reader.metadata);
  for (const auto& [name, entry] : reader.tensors) {
    const std::vector<std::uint64_t>& span = *entry.data_offsets;
    content.tensors[name] = {*entry.dtype, *entry.shape, {data + span[0], data + span[1]}};
  }
  return content;
}

}  // namespace graspctx::detail
