#pragma once
#include <string>

#include "graspctx/detector.hpp"
#include "graspctx/export.hpp"

namespace graspctx {

/// The detection as JSON, schema 1 (docs/detection-json.md). The same bytes for the same detection, the
/// timings aside. indent < 0: one line.
GRASPCTX_EXPORT std::string detection_to_json(const Detection& detection, const std::string& model_name,
                                              const std::string& model_sha256, int indent = 2);

}  // namespace graspctx
