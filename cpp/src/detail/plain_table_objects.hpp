#pragma once
#include <vector>

#include "detail/hypothesis.hpp"
#include "detail/plain_table.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// What lies on a plain table, with its whole figure, most salient first: the pixels within the table's
/// extent that are neither its colour nor its shadows', connected. A shadow is the table's colour times one
/// share of the light, without texture, and lies against the bare table; the dark inside of a bowl is
/// enclosed by the bowl.
std::vector<Hypothesis> hypotheses_on_plain_table(const RectifiedPair& pair, const Disparity& disparity,
                                                  const PlainTable& table, const StereoCamera& camera);

}  // namespace graspctx::detail
