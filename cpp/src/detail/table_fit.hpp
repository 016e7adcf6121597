#pragma once
#include <optional>

#include "detail/plain_table.hpp"
#include "graspctx/camera.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// fit_table_plane where the plain region of the left view, if it has one, is known already.
std::optional<TablePlane> fit_table_plane(const RectifiedPair& pair, const Disparity& disparity,
                                          const StereoCamera& camera, const SegmentationOptions& options,
                                          const std::optional<PlainTable>& plain);

}  // namespace graspctx::detail
