#pragma once
#include <vector>

#include "detail/plain_table.hpp"
#include "detail/relief.hpp"
#include "detail/table_frame.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// Is the plane the table's own? Its outline lies on the plane, objects' outlines above, and nothing below.
bool lies_on_plane(const PlainTable& table, const Relief& relief);

/// Of a plain table and a plane that is not its own only one can be the support: is more seen of the table?
bool outweighs_plane(const PlainTable& table, const Relief& relief);

/// The figures (CV_8UC1) of what lies on a plain table: the connected pixels within the table's extent that
/// are neither its colour nor its shadows', and what they go on as beyond its far edge. relief: over the
/// plane, null where there is none.
std::vector<cv::Mat> figures_on_plain_table(const RectifiedPair& pair, const Disparity& disparity,
                                            const PlainTable& table, const Relief* relief,
                                            const StereoCamera& camera, const SegmentationOptions& options);

}  // namespace graspctx::detail
