#pragma once
#include <optional>
#include <string>

#include "graspctx/stereo.hpp"

namespace graspctx::detail {

/// Why two views cannot be a rectified stereo pair of one scene, in words for the caller; nothing if they
/// can. Such a pair holds no object.
std::optional<std::string> why_no_stereo_pair(const RectifiedPair& pair, const Disparity& disparity,
                                              double min_reliable_share);

}  // namespace graspctx::detail
