#pragma once
#include <stdexcept>
#include <string>

#include "graspctx/export.hpp"

namespace graspctx {

/// Input that cannot be used: a missing, truncated or invalid file, an image of the wrong size or type, an
/// option out of range. The message names what it is, what is wrong with it and what was expected.
class GRASPCTX_EXPORT InvalidInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace graspctx
