// A folder of labelme's NAME.json, images beside them: https://github.com/wkentaro/labelme
#include <cmath>
#include <map>
#include <optional>

#include "detail/dataset_reader.hpp"
#include "detail/json_file.hpp"
#include "detail/regions.hpp"

namespace graspctx::detail {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_json_bytes = std::size_t{1} << 27;  // the image may be in there once more
constexpr std::size_t max_points = 100'000;                   // of one outline

/// [[x, y], …]; nothing if it is anything else.
std::optional<Polygon> points_of(const Json* list) {
  if (list == nullptr || !list->is_array() || list->size() > max_points) return std::nullopt;
  Polygon points;
  for (const Json& item : *list) {
    if (!item.is_array() || item.size() != 2) return std::nullopt;
    const std::optional<double> x = finite_number(&item[0]), y = finite_number(&item[1]);
    if (!x || !y || std::abs(*x) > max_coordinate_px || std::abs(*y) > max_coordinate_px) return std::nullopt;
    points.emplace_back(*x, *y);
  }
  return points;
}

Polygon circle(const cv::Point2d& centre, const cv::Point2d& on_it) {
  const int corners = 180;
  const double radius = std::hypot(on_it.x - centre.x, on_it.y - centre.y);
  Polygon polygon;
  for (int i = 0; i < corners; ++i) {
    const double angle_rad = 2 * CV_PI * i / corners;
    polygon.emplace_back(centre.x + radius * std::cos(angle_rad), centre.y + radius * std::sin(angle_rad));
  }
  return polygon;
}

/// The outline of one shape. Throws InvalidInput if it outlines nothing.
Polygon outline_of(const Json& shape, const std::string& name, const fs::path& file) {
  const Json* type = member(shape, "shape_type");
  const std::string kind = type != nullptr && type->is_string() ? type->get<std::string>() : "polygon";
  const std::optional<Polygon> points = points_of(member(shape, "points"));
  if (!points) {
    fail(file, name + ": 'points' must be a list of at most " + std::to_string(max_points) +
                   " pairs [x, y] within 1000000 px");
  }
  if (kind == "polygon" && points->size() >= 3) return *points;
  if (kind == "rectangle" && points->size() == 2) {
    const cv::Point2d a = points->front(), b = points->back();
    return {a, {b.x, a.y}, b, {a.x, b.y}};
  }
  if (kind == "circle" && points->size() == 2) return circle(points->front(), points->back());
  fail(file, name + ": " + short_text(type) + " of " + std::to_string(points->size()) +
                 " points outlines no region, expected a polygon of 3 or more, a rectangle or a circle of 2");
}

/// Shapes of one label and group_id are parts of one thing.
std::vector<Region> regions_of(const Json& json, const fs::path& file, Reading& reading) {
  const Json* shapes = member(json, "shapes");
  if (shapes == nullptr || !shapes->is_array()) {
    fail(file, "'shapes' is missing, expected a list as labelme writes it");
  }
  const DatasetOptions& options = reading.options;
  std::vector<Region> regions;
  std::map<std::pair<std::string, std::int64_t>, std::size_t> region_of_group;
  for (std::size_t i = 0; i < shapes->size(); ++i) {
    const Json& shape = (*shapes)[i];
    const std::string name = "shape " + std::to_string(i + 1);
    const Json* label = member(shape, "label");
    if (label == nullptr || !label->is_string() || label->get_ref<const std::string&>().empty()) {
      reading.problems.add(file, name + " has no label");
      continue;
    }
    const auto text = label->get<std::string>();
    ++reading.summary.labels[text];
    const bool is_asked_for = is_among(text, options.object_labels) || is_among(text, options.grasp_labels);
    Polygon outline;
    try {
      outline = outline_of(shape, name + " ('" + text + "')", file);
    } catch (const InvalidInput& error) {
      // Points and lines of other labels are none of our business.
      if (is_asked_for || are_labels_missing(options)) reading.problems.add(error.what());
      continue;
    }
    const Json* group = member(shape, "group_id");
    if (group != nullptr && group->is_number_integer()) {
      const auto [known, is_new] =
          region_of_group.try_emplace({text, group->get<std::int64_t>()}, regions.size());
      if (!is_new) {
        regions[known->second].polygons.push_back(std::move(outline));
        continue;
      }
    }
    regions.push_back({text, name, {std::move(outline)}, {}});
  }
  return regions;
}

void check_image_size(const Json& json, const fs::path& file, const fs::path& image_file,
                      const cv::Size& size) {
  const Json *width = member(json, "imageWidth"), *height = member(json, "imageHeight");
  const bool is_given = width != nullptr && height != nullptr && !width->is_null() && !height->is_null();
  if (is_given && (*width != size.width || *height != size.height)) {
    fail(image_file, "is " + size_text(size) + " px, expected " + short_text(width) + "x" +
                         short_text(height) + " as in " + file.filename().string());
  }
}

void read_annotated_image(const fs::path& folder, const fs::path& file, int group, Reading& reading) {
  const Json json = read_json_object(file, max_json_bytes);
  const std::vector<Region> regions = regions_of(json, file, reading);
  // A load without labels fails anyway: all it has to do is name those it finds.
  if (are_labels_missing(reading.options) && !reading.problems.is_gathering()) return;
  const Json* path = member(json, "imagePath");
  if (path == nullptr || !path->is_string()) fail(file, "'imagePath' is missing, expected an image's name");
  const fs::path image_file = path_inside(folder, path->get<std::string>(), file);
  const std::string name = image_file.lexically_relative(folder).generic_string();
  if (!is_image_wanted(name, reading.options)) return;
  LabelledView view;
  view.source = image_file.string();
  view.image_name = name;
  view.group = group;
  view.image = read_annotated_photograph(image_file);
  check_image_size(json, file, image_file, view.image.size());
  emit_objects(regions, view, file, reading);
}

}  // namespace

void read_labelme_dataset(const fs::path& folder, Reading& reading) {
  if (!is_folder(folder)) fail(folder, "is a file, expected the folder of labelme's JSON files");
  for (const fs::path& file : sorted_entries(folder)) {
    if (file.extension() != ".json") continue;
    const int group = reading.summary.images++;
    reading.problems.collect([&] { read_annotated_image(folder, file, group, reading); });
  }
  if (reading.summary.images == 0) fail(folder, "holds no JSON file, expected those of labelme");
  check_labels(folder, reading);
}

}  // namespace graspctx::detail
