#include "regions.hpp"

#include <algorithm>
#include <cmath>

#include "exif.hpp"
#include "graspctx/io/atomic_file.hpp"
#include "graspctx/io/image_file.hpp"
#include "jpeg_codec.hpp"

namespace graspctx::detail {

namespace {

namespace fs = std::filesystem;

/// cv::fillPoly would draw the outline too, half a pixel too wide all around, and its coordinates overflow.
cv::Mat polygon_mask(const Polygon& polygon, const cv::Size& size) {
  // Right of an edge inside and outside are swapped: mark where that starts in each row, then sum up.
  cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
  const auto first_centre_from = [](double coordinate, int limit) {
    return static_cast<int>(std::clamp(std::ceil(coordinate - 0.5), 0.0, static_cast<double>(limit)));
  };
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    cv::Point2d a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    if (a.y > b.y) std::swap(a, b);
    const int last = first_centre_from(b.y, size.height);
    for (int v = first_centre_from(a.y, size.height); v < last; ++v) {
      const double share = (v + 0.5 - a.y) / (b.y - a.y);
      const int u = first_centre_from(a.x + share * (b.x - a.x), size.width);
      if (u < size.width) mask.at<uchar>(v, u) ^= 255;
    }
  }
  for (int v = 0; v < size.height; ++v) {
    uchar* row = mask.ptr(v);
    for (int u = 1; u < size.width; ++u) row[u] ^= row[u - 1];
  }
  return mask;
}

cv::Mat runs_mask(const std::vector<std::uint32_t>& runs, const cv::Size& size) {
  cv::Mat columns = cv::Mat::zeros(size.width, size.height, CV_8UC1);  // transposed: runs go down the columns
  uchar* pixel = columns.ptr();
  bool is_inside = false;
  for (const std::uint32_t run : runs) {
    std::fill(pixel, pixel + run, is_inside ? 255 : 0);
    pixel += run;
    is_inside = !is_inside;
  }
  return columns.t();
}

std::string quoted(const Region& region) {
  return region.name + " ('" + region.label + "')";
}

/// 0 if nothing of the region is in the image, which is a problem.
int visible_px(const Region& region, const cv::Mat& mask, const fs::path& file, Problems& problems) {
  const int area_px = cv::countNonZero(mask);
  if (area_px == 0) problems.add(file, quoted(region) + " covers no pixel of the image");
  return area_px;
}

}  // namespace

cv::Mat region_mask(const Region& region, const cv::Size& image_size) {
  if (!region.runs.empty()) return runs_mask(region.runs, image_size);
  cv::Mat mask = cv::Mat::zeros(image_size, CV_8UC1);
  for (const Polygon& polygon : region.polygons) mask |= polygon_mask(polygon, image_size);
  return mask;
}

cv::Mat read_annotated_photograph(const fs::path& file) {
  const std::vector<std::uint8_t> bytes = read_file(file);
  const int orientation = is_jpeg(bytes) ? exif_orientation(bytes) : 1;
  if (orientation != 1) {
    fail(file, "is stored turned (EXIF orientation " + std::to_string(orientation) +
                   "), expected an image stored upright");
  }
  return read_image(file);
}

void emit_objects(const std::vector<Region>& regions, const LabelledView& view, const fs::path& file,
                  Reading& reading) {
  const DatasetOptions& options = reading.options;
  const cv::Size size = view.image.size();
  if (are_labels_missing(options)) {
    for (const Region& region : regions) {
      visible_px(region, region_mask(region, size), file, reading.problems);
    }
    return;
  }

  std::vector<LabelledView> objects;
  for (const Region& region : regions) {
    if (!is_among(region.label, options.object_labels)) continue;
    const cv::Mat mask = region_mask(region, size);
    if (visible_px(region, mask, file, reading.problems) == 0) continue;
    objects.push_back(view);
    objects.back().class_name = region.label;
    objects.back().mask = mask;
    objects.back().label = cv::Mat::zeros(size, CV_8UC1);
  }
  for (const Region& region : regions) {
    if (!is_among(region.label, options.grasp_labels)) continue;
    const cv::Mat grasp = region_mask(region, size);
    const int area_px = visible_px(region, grasp, file, reading.problems);
    if (area_px == 0) continue;
    LabelledView* best = nullptr;
    int best_px = 0;
    for (LabelledView& object : objects) {
      const int shared_px = cv::countNonZero(object.mask & grasp);
      if (shared_px > best_px) best = &object, best_px = shared_px;
    }
    if (2 * best_px >= area_px) {
      best->label |= best->mask & grasp;
      continue;
    }
    // It may be the handle of something that was not asked for.
    const bool is_of_another = std::any_of(regions.begin(), regions.end(), [&](const Region& other) {
      return !is_among(other.label, options.object_labels) && !is_among(other.label, options.grasp_labels) &&
             2 * cv::countNonZero(region_mask(other, size) & grasp) >= area_px;
    });
    if (!is_of_another) {
      reading.problems.add(file, "less than half of " + quoted(region) + " lies on an object, expected " +
                                     "outlines of " + joined(options.object_labels) +
                                     " that hold their grasp regions");
    }
  }
  for (LabelledView& object : objects) {
    if (is_wanted(object.class_name, options)) reading.emit(std::move(object));
  }
}

bool are_labels_missing(const DatasetOptions& options) {
  return options.object_labels.empty() && options.grasp_labels.empty();
}

void check_labels(const fs::path& path, Reading& reading) {
  const DatasetOptions& options = reading.options;
  std::vector<std::string> found;
  for (const auto& [label, count] : reading.summary.labels) found.push_back(label);
  const std::string found_text = found.empty() ? "none" : joined(found);
  if (are_labels_missing(options) && reading.problems.is_gathering()) return;
  if (options.object_labels.empty() || options.grasp_labels.empty()) {
    reading.problems.add(path,
                         std::string("is in the format of ") + name_of(reading.summary.format) +
                             ", expected --object-label and --grasp-label; its labels are: " + found_text);
    return;
  }
  for (const auto* labels : {&options.object_labels, &options.grasp_labels}) {
    for (const std::string& label : *labels) {
      if (!is_among(label, found)) {
        reading.problems.add(path, "has no outline labelled '" + label + "', its labels are: " + found_text);
      }
    }
  }
}

}  // namespace graspctx::detail
