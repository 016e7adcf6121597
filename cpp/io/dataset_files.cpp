#include "graspctx/io/dataset_files.hpp"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <system_error>

#include "detail/png_codec.hpp"
#include "graspctx/error.hpp"
#include "graspctx/io/atomic_file.hpp"
#include "graspctx/io/calibration_file.hpp"
#include "graspctx/io/image_file.hpp"

namespace graspctx {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int format_version = 1, scene_schema = 1;

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw InvalidInput(file.string() + ": " + what);
}

std::string size_text(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

void require_size(const fs::path& file, const cv::Mat& image, const cv::Size& expected) {
  if (image.size() != expected) {
    fail(file,
         "is " + size_text(image.size()) + " px, expected " + size_text(expected) + " like the left image");
  }
}

bool is_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

void require_folder(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error)) fail(folder, "no such folder, expected a data set");
  if (!is_folder(folder)) fail(folder, "is a file, expected the folder of a data set");
}

std::vector<fs::path> sorted_entries(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    entries.push_back(entry->path());
  }
  if (error) fail(folder, "cannot be read: " + error.message());
  std::sort(entries.begin(), entries.end());
  return entries;
}

// ---- the project's own layout (docs/dataset-format.md) ----

Json read_json(const fs::path& file) {
  const std::vector<std::uint8_t> bytes = read_file(file, std::size_t{1} << 24);
  Json json = Json::parse(bytes.begin(), bytes.end(), nullptr, false);
  if (json.is_discarded()) fail(file, "is no valid JSON");
  if (!json.is_object()) fail(file, "holds no JSON object");
  return json;
}

void check_header(const fs::path& folder) {
  const fs::path file = folder / "dataset.json";
  const Json header = read_json(file);
  const auto format = header.find("format"), number = header.find("version");
  if (format == header.end() || *format != "graspctx-dataset") {
    fail(file, "expected \"format\": \"graspctx-dataset\"");
  }
  if (number == header.end() || *number != format_version) {
    fail(file, "expected \"version\": " + std::to_string(format_version));
  }
}

/// Scenes in the order of their names. A scene that is being written ends in .partial.
std::vector<fs::path> scene_folders(const fs::path& folder) {
  std::vector<fs::path> scenes;
  for (const fs::path& entry : sorted_entries(folder)) {
    std::error_code error;
    if (entry.extension() != ".partial" && fs::exists(entry / "scene.json", error)) scenes.push_back(entry);
  }
  if (scenes.empty()) fail(folder, "holds no scene, expected sub-folders with a scene.json");
  return scenes;
}

struct SceneObject {
  int id = 0;
  std::string family;
  Json entry;  // all that scene.json says of it
};

std::vector<SceneObject> read_objects(const fs::path& scene_json) {
  const Json scene = read_json(scene_json);
  const auto schema = scene.find("schema");
  if (schema == scene.end() || *schema != scene_schema) {
    fail(scene_json, "expected \"schema\": " + std::to_string(scene_schema));
  }
  const auto list = scene.find("objects");
  if (list == scene.end() || !list->is_array()) fail(scene_json, "'objects' is missing, expected a list");
  std::vector<SceneObject> objects;
  std::set<int> ids;
  for (const Json& item : *list) {
    const bool complete = item.is_object() && item.contains("id") && item["id"].is_number_integer() &&
                          item.contains("family") && item["family"].is_string();
    if (!complete) fail(scene_json, "an object lacks its whole-number 'id' or its 'family'");
    const auto id = item["id"].get<std::int64_t>();
    if (id < 1 || id > 255)
      fail(scene_json, "an object's id is " + std::to_string(id) + ", expected 1 to 255");
    if (!ids.insert(static_cast<int>(id)).second)
      fail(scene_json, "id " + std::to_string(id) + " is given twice");
    objects.push_back({static_cast<int>(id), item["family"].get<std::string>(), item});
    if (objects.back().family.empty()) fail(scene_json, "an object's family is empty");
  }
  return objects;
}

/// The files of one view of a scene.
struct SceneView {
  cv::Mat image, instance_ids, label;
};

SceneView read_view(const fs::path& scene, const std::string& side) {
  SceneView view;
  const fs::path mask_file = scene / (side + "_mask.png"), label_file = scene / (side + "_label.png");
  view.image = read_image(scene / (side + ".png"));
  view.instance_ids = read_mask(mask_file);
  view.label = read_mask(label_file);
  require_size(mask_file, view.instance_ids, view.image.size());
  require_size(label_file, view.label, view.image.size());
  return view;
}

bool is_wanted(const std::string& family, const std::vector<std::string>& classes) {
  return classes.empty() || std::find(classes.begin(), classes.end(), family) != classes.end();
}

std::vector<LabelledView> load_scenes(const fs::path& folder, const std::vector<std::string>& classes,
                                      DatasetViews which) {
  check_header(folder);
  std::vector<LabelledView> views;
  std::set<std::string> families;
  int group = 0;
  for (const fs::path& scene : scene_folders(folder)) {
    std::vector<SceneObject> wanted;
    for (SceneObject& object : read_objects(scene / "scene.json")) {
      families.insert(object.family);
      if (is_wanted(object.family, classes)) wanted.push_back(std::move(object));
    }
    const std::vector<std::string> sides = which == DatasetViews::both
                                               ? std::vector<std::string>{"left", "right"}
                                               : std::vector<std::string>{"left"};
    for (const std::string& side : sides) {
      if (wanted.empty()) break;
      const SceneView view = read_view(scene, side);
      for (const SceneObject& object : wanted) {
        const cv::Mat mask = view.instance_ids == object.id;
        if (cv::countNonZero(mask) == 0) continue;  // hidden behind another object
        views.push_back({(scene / side).string(), object.family, group, view.image, mask, view.label & mask});
      }
    }
    ++group;
  }
  if (views.empty()) {
    std::string names;
    for (const std::string& family : families) names += (names.empty() ? "" : ", ") + family;
    fail(folder, "holds no visible object of the classes asked for, it has: " + names);
  }
  return views;
}

// ---- Saxena's layout: img/NAME.png, grasp/graspPriorityWidth_NAME.png ----

bool is_saxena(const fs::path& folder) {
  return is_folder(folder / "img") && is_folder(folder / "grasp");
}

/// The object before a plain background: what differs from the colour of the image's border.
cv::Mat segment_from_border(const fs::path& file, const cv::Mat& image) {
  cv::Mat colour = image;
  if (image.channels() == 1) cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
  const int frame_px = 3;
  if (std::min(colour.rows, colour.cols) < 4 * frame_px) fail(file, "is too small to hold an object");
  cv::Mat frame(colour.size(), CV_8UC1, cv::Scalar(255));
  frame(cv::Rect(frame_px, frame_px, colour.cols - 2 * frame_px, colour.rows - 2 * frame_px)) = cv::Scalar(0);

  // Median of the border, by channel: an object may touch it.
  cv::Scalar background;
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<uchar> values;
    for (int v = 0; v < colour.rows; ++v) {
      for (int u = 0; u < colour.cols; ++u) {
        if (frame.at<uchar>(v, u)) values.push_back(colour.at<cv::Vec3b>(v, u)[channel]);
      }
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    background[channel] = *middle;
  }
  cv::Mat difference, largest_difference, mask;
  cv::absdiff(colour, background, difference);
  cv::Mat channels[3];
  cv::split(difference, channels);
  largest_difference = cv::max(cv::max(channels[0], channels[1]), channels[2]);
  // Otsu separates object from background; below 12 grey levels there is only noise to separate.
  const double otsu = cv::threshold(largest_difference, mask, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  cv::threshold(largest_difference, mask, std::clamp(otsu, 12.0, 40.0), 255, cv::THRESH_BINARY);

  cv::Mat components, statistics, centroids;
  const int count = cv::connectedComponentsWithStats(mask, components, statistics, centroids, 8);
  int largest = 0, largest_area = 0;
  for (int i = 1; i < count; ++i) {
    const int area = statistics.at<int>(i, cv::CC_STAT_AREA);
    if (area > largest_area) largest = i, largest_area = area;
  }
  if (largest == 0) fail(file, "shows no object that differs from the image's border");
  return components == largest;
}

std::vector<LabelledView> load_saxena(const fs::path& folder, const std::vector<std::string>& classes) {
  static const std::string class_name = "object";
  if (!is_wanted(class_name, classes)) {
    fail(folder, "is in Saxena's layout and knows no classes but '" + class_name + "'");
  }
  std::vector<LabelledView> views;
  for (const fs::path& file : sorted_entries(folder / "img")) {
    if (file.extension() != ".png") continue;
    const fs::path label_file = folder / "grasp" / ("graspPriorityWidth_" + file.stem().string() + ".png");
    const cv::Mat image = read_image(file);
    const cv::Mat label_image = read_image(label_file);
    require_size(label_file, label_image, image.size());
    // Any pixel that is not black is graspable.
    cv::Mat label;
    if (label_image.channels() == 3) {
      cv::Mat channels[3];
      cv::split(label_image, channels);
      label = (channels[0] | channels[1] | channels[2]) > 0;
    } else {
      label = label_image > 0;
    }
    const cv::Mat mask = segment_from_border(file, image);
    views.push_back({file.string(), class_name, static_cast<int>(views.size()), image, mask, label & mask});
  }
  if (views.empty()) fail(folder / "img", "holds no PNG image");
  return views;
}

// ---- check ----

/// Runs checks and keeps what they complain about.
class Problems {
 public:
  template <typename Check>
  void collect(Check check) {
    try {
      check();
    } catch (const InvalidInput& error) {
      lines_.emplace_back(error.what());
    }
  }
  void add(const fs::path& file, const std::string& what) { lines_.push_back(file.string() + ": " + what); }
  std::vector<std::string> take() { return std::move(lines_); }

 private:
  std::vector<std::string> lines_;
};

/// visible_px and label_px, where scene.json gives them, are the numbers of pixels in the images.
void check_count(const SceneObject& object, const std::string& key, const std::string& side,
                 const cv::Mat& pixels, const fs::path& file, Problems& problems) {
  const auto counts = object.entry.find(key);
  if (counts == object.entry.end()) return;
  const Json stated = counts->is_object() ? counts->value(side, Json()) : Json();
  const int found = cv::countNonZero(pixels);
  if (stated != found) {
    problems.add(file, "shows " + std::to_string(found) + " px of object " + std::to_string(object.id) +
                           ", scene.json says " + key + " " + stated.dump());
  }
}

void check_view_content(const fs::path& scene, const std::string& side, const SceneView& view,
                        const std::vector<SceneObject>& objects, Problems& problems) {
  std::set<int> known{0};
  for (const SceneObject& object : objects) known.insert(object.id);
  std::set<int> unknown;
  bool label_is_binary = true, label_on_objects = true;
  for (int v = 0; v < view.label.rows; ++v) {
    const uchar* ids = view.instance_ids.ptr(v);
    const uchar* label = view.label.ptr(v);
    for (int u = 0; u < view.label.cols; ++u) {
      if (known.count(ids[u]) == 0) unknown.insert(ids[u]);
      if (label[u] != 0 && label[u] != 255) label_is_binary = false;
      if (label[u] != 0 && ids[u] == 0) label_on_objects = false;
    }
  }
  for (const int id : unknown) {
    problems.add(scene / (side + "_mask.png"),
                 "holds id " + std::to_string(id) + ", which scene.json does not list");
  }
  const fs::path label_file = scene / (side + "_label.png");
  for (const SceneObject& object : objects) {
    const cv::Mat mask = view.instance_ids == object.id;
    check_count(object, "visible_px", side, mask, scene / (side + "_mask.png"), problems);
    check_count(object, "label_px", side, view.label & mask, label_file, problems);
  }
  if (!label_is_binary) problems.add(label_file, "holds values other than 0 and 255");
  if (!label_on_objects) problems.add(label_file, "labels pixels outside of every object");
}

void check_scene(const fs::path& scene, Problems& problems) {
  std::vector<SceneObject> objects;
  problems.collect([&] { objects = read_objects(scene / "scene.json"); });
  cv::Size size;
  for (const std::string side : {"left", "right"}) {
    problems.collect([&] {
      const SceneView view = read_view(scene, side);
      if (size.empty()) size = view.image.size();
      require_size(scene / (side + ".png"), view.image, size);
      check_view_content(scene, side, view, objects, problems);
    });
  }
  problems.collect([&] {
    const fs::path file = scene / "left_depth.png";
    const std::vector<std::uint8_t> bytes = read_file(file);
    cv::Mat depth;
    try {
      depth = detail::decode_png(bytes, detail::PngPixels::as_stored);
    } catch (const InvalidInput& error) {
      fail(file, error.what());
    }
    if (depth.type() != CV_16UC1) fail(file, "has 8 bits a pixel, expected a 16-bit single-channel PNG");
    if (!size.empty()) require_size(file, depth, size);
  });
  problems.collect([&] {
    const fs::path file = scene / "calib.txt";
    const StereoCamera camera = load_calibration({file});
    const cv::Size calibrated(camera.width_px, camera.height_px);
    if (!size.empty() && calibrated != size) {
      fail(file, "is for images of " + size_text(calibrated) + " px, the images are " + size_text(size));
    }
  });
}

}  // namespace

std::vector<LabelledView> load_dataset(const fs::path& folder, const std::vector<std::string>& classes,
                                       DatasetViews views) {
  require_folder(folder);
  return is_saxena(folder) ? load_saxena(folder, classes) : load_scenes(folder, classes, views);
}

std::vector<std::string> check_dataset(const fs::path& folder) {
  Problems problems;
  problems.collect([&] {
    require_folder(folder);
    if (is_saxena(folder)) {
      load_saxena(folder, {});
      return;
    }
    problems.collect([&] { check_header(folder); });
    for (const fs::path& scene : scene_folders(folder)) check_scene(scene, problems);
  });
  return problems.take();
}

}  // namespace graspctx
