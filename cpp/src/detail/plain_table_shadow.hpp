#pragma once
#include <opencv2/core.hpp>

#include "detail/plain_table.hpp"
#include "detail/relief.hpp"

namespace graspctx::detail {

/// The image against the bare table.
struct TableComparison {
  cv::Mat sigmas;          // CV_32FC1, how far from the table's colour, in standard deviations
  cv::Mat light;           // CV_32FC1, the share of the table's light that explains the colour best
  cv::Mat off_hue;         // CV_32FC1, what that leaves, as a share of the table's brightness
  double light_noise = 0;  // standard deviation of `light`
};

/// image: CV_8UC3 of the table's size.
TableComparison compare_with_table(const cv::Mat& image, const PlainTable& table);

/// Bare table in shadow: it has the table's colour times one share of the light, no texture, and lies against
/// the lit table. What stereo sees at its outline lies on the table: the grey side of a box on a grey table
/// passes for a shadow only in one view. off_table: CV_8UC1, > 0 where the table's colour is not seen;
/// relief: null where the plane is not known. CV_8UC1, 255 = shadow.
cv::Mat shadows_on_plain_table(const TableComparison& compared, const cv::Mat& off_table,
                               const PlainTable& table, const Relief* relief);

}  // namespace graspctx::detail
