#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace graspctx::detail {

/// A tensor of a safetensors file: its type, its shape and its raw little-endian numbers.
struct Tensor {
  std::string dtype;                 // "F64", "F32", "I32" or "U8"
  std::vector<std::uint64_t> shape;  // row-major
  std::vector<std::uint8_t> bytes;
};

/// The content of a safetensors file (the format is described at
/// https://huggingface.co/docs/safetensors): the length of the header (u64, little-endian), a JSON header,
/// the tensors' bytes.
struct Safetensors {
  std::map<std::string, std::string> metadata;
  std::map<std::string, Tensor> tensors;
};

/// The same bytes for the same content: the widest numbers first, then by name, so that every tensor is
/// aligned.
std::vector<std::uint8_t> write_safetensors(const Safetensors& content);

/// Throws InvalidInput naming what is wrong. Nothing is trusted: the header's length and depth, duplicate
/// keys, types, shapes, and that the tensors cover the buffer without gap or overlap.
Safetensors read_safetensors(const std::uint8_t* bytes, std::size_t size);

}  // namespace graspctx::detail
