// COCO's annotations: one JSON file for many images, https://cocodataset.org/#format-data
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "detail/coco_file.hpp"
#include "detail/dataset_reader.hpp"
#include "detail/json_file.hpp"
#include "detail/regions.hpp"

namespace graspctx::detail {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_coordinates = 200'000;  // of one polygon

struct CocoImage {
  std::string name;
  cv::Size size;
  std::vector<Region> regions;
};

std::optional<std::int64_t> whole_number(const Json* value) {
  if (value == nullptr || !value->is_number_integer()) return std::nullopt;
  return value->get<std::int64_t>();
}

const Json& list_of(const Json& json, const char* key, const fs::path& file) {
  const Json* list = member(json, key);
  if (list == nullptr || !list->is_array()) {
    fail(file, std::string("'") + key + "' is missing, expected a list as in COCO's format");
  }
  return *list;
}

std::string numbered(const char* what, std::size_t index) {
  return std::string(what) + " " + std::to_string(index + 1);
}

std::map<std::int64_t, std::string> read_categories(const Json& json, const fs::path& file,
                                                    Problems& problems) {
  std::map<std::int64_t, std::string> categories;
  const Json& list = list_of(json, "categories", file);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::optional<std::int64_t> id = whole_number(member(list[i], "id"));
    const Json* name = member(list[i], "name");
    if (!id || name == nullptr || !name->is_string()) {
      problems.add(file, numbered("category", i) + " lacks its whole-number 'id' or its 'name'");
    } else if (!categories.emplace(*id, name->get<std::string>()).second) {
      problems.add(file, "the category id " + std::to_string(*id) + " is given twice");
    }
  }
  return categories;
}

/// Images by id, and the ids in the order of the file.
std::map<std::int64_t, CocoImage> read_images(const Json& json, const fs::path& file,
                                              std::vector<std::int64_t>& order, Problems& problems) {
  std::map<std::int64_t, CocoImage> images;
  std::set<std::string> names;
  const Json& list = list_of(json, "images", file);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::optional<std::int64_t> id = whole_number(member(list[i], "id"));
    const Json* name = member(list[i], "file_name");
    const std::optional<std::int64_t> width = whole_number(member(list[i], "width")),
                                      height = whole_number(member(list[i], "height"));
    const bool has_size =
        width && height && *width >= 1 && *width <= 32767 && *height >= 1 && *height <= 32767;
    if (!id || name == nullptr || !name->is_string() || !has_size) {
      problems.add(file,
                   numbered("image", i) +
                       " lacks its whole-number 'id', 'width' or 'height' (1 to 32767) or its 'file_name'");
      continue;
    }
    const auto text = name->get<std::string>();
    if (images.count(*id) != 0) {
      problems.add(file, "the image id " + std::to_string(*id) + " is given twice");
    } else if (!names.insert(text).second) {
      // Twice the same picture would stand on both sides of a fold.
      problems.add(file, "two images have the file_name '" + text + "'");
    } else {
      images[*id] = {text, cv::Size(static_cast<int>(*width), static_cast<int>(*height)), {}};
      order.push_back(*id);
    }
  }
  return images;
}

/// [[x1, y1, x2, y2, …], …]
std::vector<Polygon> polygons_of(const Json& segmentation, const std::string& name, const fs::path& file) {
  std::vector<Polygon> polygons;
  for (const Json& item : segmentation) {
    if (!item.is_array() || item.size() < 6 || item.size() % 2 != 0 || item.size() > max_coordinates) {
      fail(file, name + ": expected polygons [x1, y1, x2, y2, ...] of 3 to " +
                     std::to_string(max_coordinates / 2) + " points");
    }
    Polygon polygon;
    for (std::size_t i = 0; i < item.size(); i += 2) {
      const std::optional<double> x = finite_number(&item[i]), y = finite_number(&item[i + 1]);
      if (!x || !y || std::abs(*x) > max_coordinate_px || std::abs(*y) > max_coordinate_px) {
        fail(file, name + ": expected coordinates within 1000000 px");
      }
      polygon.emplace_back(*x, *y);
    }
    polygons.push_back(std::move(polygon));
  }
  if (polygons.empty()) fail(file, name + ": 'segmentation' is empty, expected polygons");
  return polygons;
}

/// Compressed counts: numbers in groups of 5 bits, lowest first, as characters from '0' on; bit 5 says that
/// more follow, bit 4 of the last is the sign. From the fourth number on each is the difference to the one
/// but last. Nothing if the text is no such code.
std::optional<std::vector<std::int64_t>> decoded_counts(const std::string& text) {
  std::vector<std::int64_t> counts;
  for (std::size_t at = 0; at < text.size();) {
    std::int64_t value = 0;
    int bits = 0, group = 0;
    do {
      if (at == text.size() || text[at] < '0' || text[at] > 'o' || bits > 35) return std::nullopt;
      group = text[at++] - '0';
      value |= static_cast<std::int64_t>(group & 31) << bits;
      bits += 5;
    } while ((group & 32) != 0);
    if ((group & 16) != 0) value -= std::int64_t{1} << bits;
    if (counts.size() > 2) value += counts[counts.size() - 2];
    if (value < 0 || value > UINT32_MAX) return std::nullopt;
    counts.push_back(value);
  }
  return counts;
}

/// {"size": [height, width], "counts": [runs] or "compressed"}
std::vector<std::uint32_t> runs_of(const Json& segmentation, const cv::Size& image_size,
                                   const std::string& name, const fs::path& file) {
  const Json* size = member(segmentation, "size");
  const Json expected_size{image_size.height, image_size.width};
  if (size == nullptr || *size != expected_size) {
    fail(file, name + ": the runs' 'size' is " + short_text(size) + ", expected " +
                   short_text(&expected_size) + ", height and width of its image");
  }
  const Json* counts = member(segmentation, "counts");
  std::optional<std::vector<std::int64_t>> runs;
  if (counts != nullptr && counts->is_string()) runs = decoded_counts(counts->get_ref<const std::string&>());
  if (counts != nullptr && counts->is_array()) {
    runs.emplace();
    for (const Json& item : *counts) {
      const std::optional<std::int64_t> run = whole_number(&item);
      if (!run || *run < 0)
        fail(file, name + ": 'counts' holds " + short_text(&item) + ", expected whole numbers");
      runs->push_back(*run);
    }
  }
  if (!runs) fail(file, name + ": 'counts' is neither a list of runs nor COCO's compressed text");
  const std::int64_t pixels = image_size.area();
  std::int64_t total = 0;
  for (const std::int64_t run : *runs) {
    total += std::min(run, pixels + 1);
    if (total > pixels) break;
  }
  if (total != pixels) {
    fail(file, name + ": the runs cover " + (total > pixels ? "more" : "less") + " than the " +
                   std::to_string(pixels) + " px of its image");
  }
  return {runs->begin(), runs->end()};
}

void add_annotation(const Json& annotation, const std::string& name, const fs::path& file,
                    const std::map<std::int64_t, std::string>& categories,
                    std::map<std::int64_t, CocoImage>& images, Reading& reading) {
  const Json *image_id = member(annotation, "image_id"), *category_id = member(annotation, "category_id");
  const auto image = images.find(whole_number(image_id).value_or(INT64_MIN));
  const auto category = categories.find(whole_number(category_id).value_or(INT64_MIN));
  if (image == images.end()) {
    fail(file, name + ": 'image_id' is " + short_text(image_id) + ", expected one of 'images'");
  }
  if (category == categories.end()) {
    fail(file, name + ": 'category_id' is " + short_text(category_id) + ", expected one of 'categories'");
  }
  const std::string& label = category->second;
  ++reading.summary.labels[label];
  Region region{label, name, {}, {}};
  const Json* segmentation = member(annotation, "segmentation");
  const auto read_region = [&] {
    const std::string shown = name + " ('" + label + "')";
    if (segmentation != nullptr && segmentation->is_array()) {
      region.polygons = polygons_of(*segmentation, shown, file);
    } else if (segmentation != nullptr && segmentation->is_object()) {
      region.runs = runs_of(*segmentation, image->second.size, shown, file);
    } else {
      fail(file, shown + " has no 'segmentation', expected polygons or runs; a box is no outline");
    }
    image->second.regions.push_back(std::move(region));
  };
  const DatasetOptions& options = reading.options;
  if (is_among(label, options.object_labels) || is_among(label, options.grasp_labels) ||
      are_labels_missing(options)) {
    read_region();
    return;
  }
  try {
    read_region();
  } catch (const InvalidInput&) {  // boxes and key points of other labels are none of our business
  }
}

void read_annotated_image(const fs::path& file, const CocoImage& image, int group, Reading& reading) {
  const DatasetOptions& options = reading.options;
  const bool has_object = std::any_of(image.regions.begin(), image.regions.end(), [&](const Region& region) {
    return is_among(region.label, options.object_labels);
  });
  if (!has_object && !reading.problems.is_gathering()) return;  // saves reading the image
  if (!is_image_wanted(image.name, options)) return;
  LabelledView view;
  const fs::path image_file = coco_image_file(file, image.name);
  view.source = image_file.string();
  view.image_name = image.name;
  view.group = group;
  view.image = read_annotated_photograph(image_file);
  require_size(image_file, view.image, image.size, "in " + file.filename().string());
  emit_objects(image.regions, view, file, reading);
}

}  // namespace

void read_coco_dataset(const fs::path& path, Reading& reading) {
  const fs::path file = find_coco_file(path);
  Problems& problems = reading.problems;
  const Json json = read_json_object(file, max_coco_bytes);
  const std::map<std::int64_t, std::string> categories = read_categories(json, file, problems);
  std::vector<std::int64_t> order;
  std::map<std::int64_t, CocoImage> images = read_images(json, file, order, problems);

  const Json& annotations = list_of(json, "annotations", file);
  std::set<std::int64_t> ids;
  for (std::size_t i = 0; i < annotations.size(); ++i) {
    const std::optional<std::int64_t> id = whole_number(member(annotations[i], "id"));
    if (id && !ids.insert(*id).second) {
      problems.add(file, "the annotation id " + std::to_string(*id) + " is given twice");
    }
    const std::string name =
        id ? "annotation " + std::to_string(*id) : numbered("annotation without id, number", i);
    problems.collect([&] { add_annotation(annotations[i], name, file, categories, images, reading); });
  }
  if (annotations.empty()) problems.add(file, "holds no annotation");
  check_labels(path, reading);
  for (const std::int64_t id : order) {
    const int group = reading.summary.images++;
    problems.collect([&] { read_annotated_image(file, images[id], group, reading); });
  }
}

}  // namespace graspctx::detail
