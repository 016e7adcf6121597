#pragma once
#include <optional>
#include <string>
#include <vector>

#include "graspctx/stereo.hpp"

namespace graspctx::detail {

struct PairChecks {
  /// Why the two views cannot be a rectified stereo pair of one scene; such a pair holds no object.
  std::optional<std::string> refusal;
  std::vector<std::string> warnings;
  std::optional<double> vertical_offset_px;
};

/// Are these two views a rectified stereo pair of one scene, and how well are they rectified?
PairChecks check_pair(const RectifiedPair& pair, const Disparity& disparity, double min_reliable_share);

}  // namespace graspctx::detail
