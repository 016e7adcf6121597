#pragma once
#include <opencv2/core.hpp>
#include <optional>

namespace graspctx::detail {

/// A support without texture. Stereo knows nothing of it, but in colour it is the easiest thing to see: a
/// large region whose colour changes slowly.
struct PlainTable {
  cv::Mat region;    // CV_8UC1 of the image's size, 255 where the table's own colour is seen
  cv::Mat extent;    // CV_8UC1, 255 in its convex hull: the table, and what hides it
  cv::Mat colour;    // CV_32FC3, the colour of the bare table everywhere, as far as the image goes
  cv::Scalar sigma;  // standard deviation (grey levels) of a pixel around that colour, by channel
};

/// The plain region that may be a support: among the large ones the one that fills the most of the image,
/// those in its lower part before those in its upper. Whether it is a table or a wall no colour can tell.
/// Nothing if everything is textured. image: CV_8UC3 or CV_8UC1.
std::optional<PlainTable> find_plain_table(const cv::Mat& image);

/// Where stereo sees a plain table: on its border, on outlines of shadows, and where objects touch it.
/// CV_8UC1, 255 within `within_px` of the region's outline, but not along the image's sides. Disparities
/// there belong to the table or to something above it, except for a few of the ground beyond its border.
cv::Mat plain_table_outline(const PlainTable& table, int within_px);

}  // namespace graspctx::detail
