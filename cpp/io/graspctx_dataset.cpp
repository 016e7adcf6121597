// The project's own layout: scenes of stereo pairs with masks and labels (docs/dataset-format.md).
#include <algorithm>
#include <set>
#include <system_error>

#include "detail/dataset_reader.hpp"
#include "detail/graspctx_scene.hpp"
#include "graspctx/io/image_file.hpp"

namespace graspctx::detail {

namespace fs = std::filesystem;

namespace {

constexpr int format_version = 1, scene_schema = 1;
constexpr std::size_t max_json_bytes = std::size_t{1} << 24;

}  // namespace

Json read_dataset_header(const fs::path& folder) {
  const fs::path file = folder / "dataset.json";
  Json header = read_json_object(file, max_json_bytes);
  const Json *format = member(header, "format"), *number = member(header, "version");
  if (format == nullptr || *format != "graspctx-dataset") {
    fail(file, "'format' is " + short_text(format) + ", expected \"graspctx-dataset\"");
  }
  if (number == nullptr || *number != format_version) {
    fail(file, "'version' is " + short_text(number) + ", expected " + std::to_string(format_version));
  }
  return header;
}

std::vector<fs::path> scene_folders(const fs::path& folder) {
  std::vector<fs::path> scenes;
  for (const fs::path& entry : sorted_entries(folder)) {
    std::error_code error;
    if (entry.extension() != ".partial" && fs::exists(entry / "scene.json", error)) scenes.push_back(entry);
  }
  if (scenes.empty()) fail(folder, "holds no scene, expected sub-folders with a scene.json");
  return scenes;
}

Json read_scene_json(const fs::path& scene_json) {
  Json scene = read_json_object(scene_json, max_json_bytes);
  const Json* schema = member(scene, "schema");
  if (schema == nullptr || *schema != scene_schema) {
    fail(scene_json, "'schema' is " + short_text(schema) + ", expected " + std::to_string(scene_schema));
  }
  return scene;
}

std::vector<SceneObject> scene_objects(const Json& scene, const fs::path& scene_json, Problems& problems) {
  const Json* list = member(scene, "objects");
  if (list == nullptr || !list->is_array()) fail(scene_json, "'objects' is missing, expected a list");
  std::vector<SceneObject> objects;
  std::set<std::int64_t> ids;
  for (const Json& item : *list) {
    const Json *id = member(item, "id"), *family = member(item, "family");
    if (id == nullptr || !id->is_number_integer() || *id < 1 || *id > 255) {
      problems.add(scene_json,
                   "an object's 'id' is " + short_text(id) + ", expected a whole number from 1 to 255");
    } else if (family == nullptr || !family->is_string() || family->get_ref<const std::string&>().empty()) {
      problems.add(scene_json, "the 'family' of object " + short_text(id) + " is " + short_text(family) +
                                   ", expected a name");
    } else if (!ids.insert(id->get<std::int64_t>()).second) {
      problems.add(scene_json,
                   "the id " + short_text(id) + " is given twice, expected one object for each id");
    } else {
      objects.push_back({id->get<int>(), family->get<std::string>(), &item});
    }
  }
  return objects;
}

SceneView read_scene_view(const fs::path& scene, const std::string& side) {
  SceneView view;
  const fs::path mask_file = scene / (side + "_mask.png"), label_file = scene / (side + "_label.png");
  view.image = read_image(scene / (side + ".png"));
  view.instance_ids = read_mask(mask_file);
  view.label = read_mask(label_file);
  require_size(mask_file, view.instance_ids, view.image.size());
  require_size(label_file, view.label, view.image.size());
  return view;
}

void read_graspctx_dataset(const fs::path& folder, Reading& reading) {
  read_dataset_header(folder);
  std::set<std::string> families;
  bool found_any = false;
  for (const fs::path& scene_folder : scene_folders(folder)) {
    const int group = reading.summary.scenes++;
    const std::string name = scene_folder.filename().string();
    if (!is_image_wanted(name, reading.options)) continue;
    const fs::path scene_json = scene_folder / "scene.json";
    const Json scene = read_scene_json(scene_json);
    std::vector<SceneObject> objects = scene_objects(scene, scene_json, reading.problems);
    for (const SceneObject& object : objects) families.insert(object.family);
    objects.erase(
        std::remove_if(objects.begin(), objects.end(),
                       [&](const SceneObject& object) { return !is_wanted(object.family, reading.options); }),
        objects.end());
    const bool left_only = reading.options.views == DatasetViews::left;
    for (const std::string side : {"left", "right"}) {
      if (objects.empty() || (left_only && side == "right")) break;
      const SceneView view = read_scene_view(scene_folder, side);
      for (const SceneObject& object : objects) {
        const cv::Mat mask = view.instance_ids == object.id;
        if (cv::countNonZero(mask) == 0) continue;  // hidden behind another object
        found_any = true;
        reading.emit({(scene_folder / side).string(), object.family, group, view.image, mask,
                      view.label & mask, name});
      }
    }
  }
  if (families.empty() && !reading.options.images.empty()) fail(folder, no_image_wanted(reading.options));
  if (!found_any) {
    fail(folder, "holds no visible object of the classes asked for, it has: " +
                     joined({families.begin(), families.end()}));
  }
}

}  // namespace graspctx::detail
