#pragma once
#include <vector>

#include "detail/regions.hpp"

namespace graspctx::detail {

/// What the trees of the grouping are asked about; NaN where unknown. The order is theirs: after a change,
/// tools/train_grouping.
using Features = std::vector<float>;

/// Is the region part of an object, rather than of the table, a wall or a shadow?
Features foreground_features(const RegionGraph& graph, int region, const SceneCues& cues);

/// Are the two regions, which meet at the border, parts of one object?
Features union_features(const Region& a, const Region& b, const Border& border);

/// Is the region, grown together from others, an object as a whole?
Features object_features(const RegionGraph& graph, int region);

}  // namespace graspctx::detail
