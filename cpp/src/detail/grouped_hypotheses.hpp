#pragma once
#include <vector>

#include "detail/hypothesis.hpp"
#include "detail/table_view.hpp"
#include "graspctx/camera.hpp"
#include "graspctx/stereo.hpp"

namespace graspctx::detail {

/// Objects on a table by all cues at once (III-A, Fig. 2c): the view falls into small regions of one colour;
/// what each is, and which of them belong together, boosted trees say that were trained on labelled
/// scenes (tools/train_grouping). The most salient first.
std::vector<Hypothesis> hypotheses_by_grouping(const RectifiedPair& pair, const Disparity& disparity,
                                               const StereoCamera& camera, const TableView& view,
                                               const SegmentationOptions& options);

}  // namespace graspctx::detail
