#pragma once
#include <string>

#include "graspctx/explanation.hpp"
#include "graspctx/export.hpp"

namespace graspctx {

/// The explanation as JSON, schema 1 (docs/explain.md). The same bytes for the same explanation. indent < 0:
/// one line.
GRASPCTX_EXPORT std::string explanation_to_json(const GraspExplanation& explanation,
                                                const std::string& model_name,
                                                const std::string& model_sha256, int indent = 2);

}  // namespace graspctx
