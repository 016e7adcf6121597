#pragma once
#include <optional>
#include <vector>

#include "detail/hypothesis.hpp"
#include "detail/plain_table.hpp"
#include "detail/relief.hpp"
#include "detail/table_frame.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// What is seen of the table: its plane, what stands out of it, and, if it has no texture, its colour.
struct TableView {
  std::optional<TablePlane> plane;
  Relief relief;                   // with a plane
  TableFrame frame;                // with a plane
  std::vector<Hypothesis> raised;  // with a plane: see hypotheses_on_table
  std::optional<PlainTable> plain;
  bool plain_on_plane = false;  // the plain region lies on the plane
  /// CV_8UC1, 255 = a first guess at what colour tells from the table: what has not the colour of a plain
  /// table nor of a shadow on it, and what is low on a textured one. At the level `colour`, else empty.
  cv::Mat first_guess;

  /// CV_8UC1 of the image's size, 255 where the table is seen, or what is below it; empty if no table is
  /// known.
  cv::Mat ground() const;
};

TableView look_at_table(const RectifiedPair& pair, const Disparity& disparity, const StereoCamera& camera,
                        const SegmentationOptions& options);

}  // namespace graspctx::detail
