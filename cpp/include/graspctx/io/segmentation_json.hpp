#pragma once
#include <string>
#include <utility>
#include <vector>

#include "graspctx/export.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx {

/// The segmentation as JSON, schema 1 (docs/segmentation-json.md). cues: the level it was made with;
/// timings_ms: stage and time, in order. The same bytes for the same segmentation, the timings aside.
/// indent < 0: one line.
GRASPCTX_EXPORT std::string segmentation_to_json(
    const Segmentation& segmentation, CueLevel cues,
    const std::vector<std::pair<std::string, double>>& timings_ms = {}, int indent = 2);

}  // namespace graspctx
