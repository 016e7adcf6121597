#pragma once
#include <vector>

#include "detail/hypothesis.hpp"
#include "detail/relief.hpp"
#include "detail/table_frame.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// What stands on the table, from a bird's-eye view of the relief, most salient first.
std::vector<Hypothesis> hypotheses_on_table(const RectifiedPair& pair, const Relief& relief,
                                            const TablePlane& plane, const TableFrame& frame,
                                            const StereoCamera& camera, const SegmentationOptions& options);

}  // namespace graspctx::detail
