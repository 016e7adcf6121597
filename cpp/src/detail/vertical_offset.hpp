#pragma once
#include <opencv2/core.hpp>
#include <optional>

#include "graspctx/stereo.hpp"

namespace graspctx::detail {

/// What is left of the difference between the rows of the two views.
struct VerticalOffset {
  double offset_px = 0;     // in the middle of the image; > 0: everything lies lower in the right view
  double rotation_rad = 0;  // of the right view; > 0: the offset grows to the right
  int corners = 0;          // that were found in both views
};

/// Measured on corners of the left view, found again in the right one a few rows up or down. Nothing if too
/// few are found.
std::optional<VerticalOffset> measure_vertical_offset(const RectifiedPair& pair, const Disparity& disparity);

}  // namespace graspctx::detail
