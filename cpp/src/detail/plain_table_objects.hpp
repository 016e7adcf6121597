#pragma once
#include <vector>

#include "detail/plain_table.hpp"

namespace graspctx::detail {

/// What lies on a plain table, by colour alone.
struct PlainTableFigures {
  cv::Mat ground;                // CV_8UC1, 255 where bare table is seen, in light or in shadow
  std::vector<cv::Mat> figures;  // CV_8UC1 of the image's size: connected figures within the extent
};

/// The pixels that are neither the table's colour nor its shadows', connected. A shadow is the table's
/// colour times one share of the light, without texture, and lies against the bare table beside what casts
/// it; the dark inside of a bowl is enclosed by the bowl.
PlainTableFigures figures_on_plain_table(const cv::Mat& image, const PlainTable& table);

}  // namespace graspctx::detail
