#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "graspctx/dataset.hpp"
#include "graspctx/export.hpp"

namespace graspctx {

enum class DatasetViews { left, both };

/// Read the labelled views of a data set in the project's own layout (docs/dataset-format.md), scenes in the
/// order of their names; objects of other classes than `classes` (empty: all) are passed over. A folder with
/// img/ and grasp/ is read in the layout of Saxena et al.: monocular, one object before a plain background,
/// class "object". Throws InvalidInput naming the file, also if no view is left.
GRASPCTX_EXPORT std::vector<LabelledView> load_dataset(const std::filesystem::path& folder,
                                                       const std::vector<std::string>& classes = {},
                                                       DatasetViews views = DatasetViews::both);

/// Every problem of a data set, one line each; empty if it is sound.
GRASPCTX_EXPORT std::vector<std::string> check_dataset(const std::filesystem::path& folder);

}  // namespace graspctx
