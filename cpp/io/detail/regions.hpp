#pragma once
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "dataset_reader.hpp"

namespace graspctx::detail {

using Polygon = std::vector<cv::Point2d>;

/// What somebody outlined in an image with an annotation tool: the union of polygons, or runs.
struct Region {
  std::string label;
  std::string name;  // for messages: "shape 3", "annotation 17"
  /// px from the upper left corner of the image, where labelme and COCO start to count: the first pixel's
  /// centre is (0.5, 0.5).
  std::vector<Polygon> polygons;
  /// COCO: lengths of runs down the columns, outside and inside in turn, first outside; they fill the image.
  std::vector<std::uint32_t> runs;
};

/// The largest coordinate of a polygon that a reader accepts; farther out is no annotation but a mistake.
inline constexpr double max_coordinate_px = 1e6;

/// CV_8UC1, 255 where a pixel's centre lies inside (even-odd rule for each polygon). Coordinates up to
/// max_coordinate_px.
cv::Mat region_mask(const Region& region, const cv::Size& image_size);

/// read_image for annotated images: throws InvalidInput for a photograph that viewers turn by its EXIF
/// orientation. Annotation tools turn it too, but this program takes pixels as stored, and outlines would lie
/// elsewhere.
cv::Mat read_annotated_photograph(const std::filesystem::path& file);

/// The objects among an image's regions, by the labels of the options, each with the grasp regions on it: a
/// grasp region belongs to the object that holds most of it. Without labels the regions are only checked.
/// `view` brings source, group and image; a problem names `file`.
void emit_objects(const std::vector<Region>& regions, const LabelledView& view,
                  const std::filesystem::path& file, Reading& reading);

/// Neither kind of label given.
bool are_labels_missing(const DatasetOptions& options);
/// To be asked at the end: were labels given, and are they in the data set? Throws InvalidInput if they are
/// missing and a load needs them.
void check_labels(const std::filesystem::path& path, Reading& reading);

}  // namespace graspctx::detail
