#pragma once
#include <vector>

#include "detail/hypothesis.hpp"
#include "detail/plain_table.hpp"
#include "detail/relief.hpp"
#include "detail/table_frame.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// Is the plane the table's own? Its outline lies on the plane, objects' outlines above, and nothing below.
bool lies_on_plane(const PlainTable& table, const Relief& relief);

/// Of a plain table and a plane that is not its own only one can be the support: is more seen of the table?
bool outweighs_plane(const PlainTable& table, const Relief& relief);

/// Is there more of the table beyond the plain region, with texture? Otherwise what is there is background.
bool goes_on_textured(const PlainTable& table, const Relief& relief);

/// What lies on a plain table, with its whole figure, most salient first: the connected pixels within the
/// table's extent that are neither its colour nor its shadows', and what they go on as beyond its far edge.
/// relief: over the plane, null where there is none.
std::vector<Hypothesis> hypotheses_on_plain_table(const RectifiedPair& pair, const Disparity& disparity,
                                                  const PlainTable& table, const Relief* relief,
                                                  const StereoCamera& camera,
                                                  const SegmentationOptions& options);

/// Where something stands on the table, seen from right above: its convex hull (m), empty where unknown.
using Footprint = std::vector<cv::Point2f>;
Footprint footprint_of(const cv::Mat& seeds, const Relief& relief, const TablePlane& plane,
                       const TableFrame& frame, const StereoCamera& camera);

/// Objects that touch are one figure by colour. Where depth tells several in it that stand in different
/// places, each gets the part of the figure around its own, up to the image's edges; otherwise the whole.
/// footprints: of by_depth; empty without a plane.
std::vector<Hypothesis> split_by_depth(const Hypothesis& whole, const std::vector<Hypothesis>& by_depth,
                                       const std::vector<Footprint>& footprints, const cv::Mat& image,
                                       const StereoCamera& camera);

}  // namespace graspctx::detail
