// What `graspctx_cli check` demands of the project's own layout (docs/dataset-format.md).
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <system_error>

#include "detail/dataset_reader.hpp"
#include "detail/graspctx_scene.hpp"
#include "detail/png_codec.hpp"
#include "graspctx/io/atomic_file.hpp"
#include "graspctx/io/calibration_file.hpp"
#include "graspctx/io/image_file.hpp"

namespace graspctx::detail {

namespace {

namespace fs = std::filesystem;

constexpr double same_px = 0.02, same_m = 1e-5;  // calib.txt and scene.json round differently
constexpr double rigid_tolerance = 1e-4;

/// An 8-bit image as the layout wants it: a 16-bit PNG would be scaled down without a word.
void require_8_bit(const fs::path& file) {
  const std::size_t bit_depth_at = 24;  // in the header of a PNG file
  const std::vector<std::uint8_t> bytes = read_file(file);
  if (is_png(bytes) && bytes.size() > bit_depth_at && bytes[bit_depth_at] == 16) {
    fail(file, "has 16 bits a channel, expected an 8-bit image");
  }
}

cv::Mat read_depth(const fs::path& file) {
  cv::Mat depth;
  const std::vector<std::uint8_t> bytes = read_file(file);
  try {
    depth = decode_png(bytes, PngPixels::as_stored);
  } catch (const InvalidInput& error) {
    fail(file, error.what());
  }
  if (depth.type() != CV_16UC1) fail(file, "has 8 bits a pixel, expected a 16-bit single-channel PNG");
  return depth;
}

// ---- scene.json: numbers ----

/// N finite numbers; nothing otherwise.
template <std::size_t N>
std::optional<std::array<double, N>> numbers_of(const Json* list) {
  if (list == nullptr || !list->is_array() || list->size() != N) return std::nullopt;
  std::array<double, N> numbers;
  for (std::size_t i = 0; i < N; ++i) {
    const std::optional<double> number = finite_number(&(*list)[i]);
    if (!number) return std::nullopt;
    numbers[i] = *number;
  }
  return numbers;
}

/// A rigid transform, or a problem that names it.
std::optional<Eigen::Matrix4d> transform_of(const Json* rows, const std::string& name, const fs::path& file,
                                            Problems& problems) {
  Eigen::Matrix4d transform;
  bool is_matrix = rows != nullptr && rows->is_array() && rows->size() == 4;
  for (int row = 0; is_matrix && row < 4; ++row) {
    const auto numbers = numbers_of<4>(&(*rows)[static_cast<std::size_t>(row)]);
    is_matrix = numbers.has_value();
    if (numbers) transform.row(row) = Eigen::Map<const Eigen::RowVector4d>(numbers->data());
  }
  if (!is_matrix) {
    problems.add(file, name + " is " + short_text(rows) + ", expected 4 rows of 4 finite numbers");
    return std::nullopt;
  }
  const Eigen::Matrix3d rotation = transform.topLeftCorner<3, 3>();
  const bool is_rigid =
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <
          rigid_tolerance &&
      rotation.determinant() > 0 && transform.row(3) == Eigen::RowVector4d(0, 0, 0, 1);
  if (!is_rigid) {
    problems.add(file,
                 name + " is no rigid transform, expected a rotation, a translation and the row 0 0 0 1");
    return std::nullopt;
  }
  return transform;
}

void check_table_plane(const Json& scene, const std::optional<Eigen::Matrix4d>& cam_from_table,
                       const fs::path& file, Problems& problems) {
  const Json* plane = member(scene, "table_plane");
  if (plane == nullptr || plane->is_null()) return;
  const auto normal_numbers = numbers_of<3>(member(*plane, "normal"));
  const std::optional<double> offset_m = finite_number(member(*plane, "offset_m"));
  if (!normal_numbers || !offset_m) {
    problems.add(file,
                 "table_plane is " + short_text(plane) + ", expected a normal of 3 numbers and an offset_m");
    return;
  }
  const Eigen::Vector3d normal = Eigen::Map<const Eigen::Vector3d>(normal_numbers->data());
  if (std::abs(normal.norm() - 1) > rigid_tolerance) {
    problems.add(file, "the normal of table_plane has not the length 1");
  } else if (cam_from_table) {
    const Eigen::Vector3d up = cam_from_table->block<3, 1>(0, 2);
    const double expected_m = -up.dot(cam_from_table->block<3, 1>(0, 3));
    if ((normal - up).norm() > 1e-3 || std::abs(*offset_m - expected_m) > 1e-3) {
      problems.add(file, "table_plane and cam_from_table are different planes");
    }
  }
}

/// A rendered scene says where everything stands; a recorded one need not, but then nowhere.
void check_poses(const Json& scene, const std::vector<SceneObject>& objects, const fs::path& file,
                 Problems& problems) {
  std::optional<Eigen::Matrix4d> cam_from_table;
  const Json* table = member(scene, "cam_from_table");
  if (table != nullptr) cam_from_table = transform_of(table, "cam_from_table", file, problems);
  check_table_plane(scene, cam_from_table, file, problems);
  bool has_poses = table != nullptr;
  for (const SceneObject& object : objects) has_poses |= member(*object.entry, "cam_from_object") != nullptr;
  if (!has_poses) return;
  for (const SceneObject& object : objects) {
    transform_of(member(*object.entry, "cam_from_object"),
                 "cam_from_object of object " + std::to_string(object.id), file, problems);
  }
}

void check_scene_size(const Json& scene, const cv::Size& size, const fs::path& file, Problems& problems) {
  const Json* stated = member(scene, "image_size");
  const Json found{size.width, size.height};
  if (stated != nullptr && *stated != found) {
    problems.add(file, "'image_size' is " + short_text(stated) + ", expected " + short_text(&found) +
                           " like the left image");
  }
}

/// The camera stands in two files.
void check_camera(const Json& scene, const StereoCamera& calibrated, const fs::path& scene_json,
                  const fs::path& calibration, Problems& problems) {
  const Json* camera = member(scene, "camera");
  if (camera == nullptr) return;
  const auto compare = [&](const char* key, std::optional<double> stated, double found, double tolerance) {
    const Json found_number = found;
    const Json* stated_number = member(*camera, key);
    if (!stated) {
      problems.add(scene_json, std::string("camera: '") + key + "' is " + short_text(stated_number) +
                                   ", expected finite numbers");
    } else if (std::abs(*stated - found) > tolerance) {
      problems.add(calibration, std::string("disagrees with scene.json: ") + key + " is " +
                                    short_text(&found_number) + ", expected " + short_text(stated_number));
    }
  };
  compare("focal_px", finite_number(member(*camera, "focal_px")), calibrated.focal_px, same_px);
  const auto centre = numbers_of<2>(member(*camera, "centre_px"));
  for (int i = 0; i < 2; ++i) {
    const auto at = static_cast<std::size_t>(i);
    compare("centre_px", centre ? std::optional<double>((*centre)[at]) : std::nullopt,
            calibrated.centre_px[i], same_px);
  }
  compare("baseline_m", finite_number(member(*camera, "baseline_m")), calibrated.baseline_m, same_m);
  compare("doffs_px", finite_number(member(*camera, "doffs_px")), calibrated.doffs_px, same_px);
}

/// A scene's difficulties by name; the summary counts the scenes of each word, and keeps the range of
/// numbers.
void check_axes(const Json& scene, const fs::path& file, Problems& problems, DatasetSummary& summary) {
  const Json* axes = member(scene, "axes");
  if (axes == nullptr) return;
  if (!axes->is_object()) {
    problems.add(file, "'axes' is " + short_text(axes) + ", expected names with values");
    return;
  }
  for (const auto& [name, value] : axes->items()) {
    if (value.is_string() || value.is_boolean()) {
      const std::string text = value.is_string() ? value.get<std::string>() : short_text(&value);
      ++summary.axes[name].scenes_of[text];
    } else if (const std::optional<double> number = finite_number(&value)) {
      DatasetSummary::AxisSummary& axis = summary.axes[name];
      const bool is_first = axis.numbers++ == 0;
      axis.lowest = is_first ? *number : std::min(axis.lowest, *number);
      axis.highest = is_first ? *number : std::max(axis.highest, *number);
    } else {
      problems.add(file, "the axis '" + name + "' is " + short_text(&value) +
                             ", expected a word, a number or true/false");
    }
  }
}

// ---- images ----

/// visible_px and label_px, where scene.json gives them, are the numbers of pixels in the images.
void check_count(const SceneObject& object, const char* key, const std::string& side, int found_px,
                 const fs::path& file, Problems& problems) {
  const Json* counts = member(*object.entry, key);
  if (counts == nullptr) return;
  const Json* stated = member(*counts, side.c_str());
  if (stated == nullptr || *stated != found_px) {
    problems.add(file, "shows " + std::to_string(found_px) + " px of object " + std::to_string(object.id) +
                           ", expected as in scene.json: " + key + " " + short_text(stated));
  }
}

/// Shares of something are 0 to 1; null where there is nothing to have a share of.
void check_share(const SceneObject& object, const char* key, const std::string& side, const fs::path& file,
                 Problems& problems) {
  const Json* shares = member(*object.entry, key);
  const Json* stated = shares == nullptr ? nullptr : member(*shares, side.c_str());
  if (shares == nullptr || (stated != nullptr && stated->is_null())) return;
  const std::optional<double> share = finite_number(stated);
  if (!share || *share < 0 || *share > 1) {
    problems.add(file, std::string(key) + " of object " + std::to_string(object.id) + " is " +
                           short_text(stated) + " for the " + side + " view, expected 0 to 1");
  }
}

bool says_hidden(const SceneObject& object, const std::string& side) {
  const Json* counts = member(*object.entry, "visible_px");
  const Json* stated = counts == nullptr ? nullptr : member(*counts, side.c_str());
  return stated != nullptr && *stated == 0;
}

/// Which objects the view shows; what it holds that it should not is a problem.
std::set<int> check_view_content(const fs::path& scene, const std::string& side, const SceneView& view,
                                 const std::vector<SceneObject>& objects, Problems& problems,
                                 DatasetSummary& summary) {
  const fs::path mask_file = scene / (side + "_mask.png"), label_file = scene / (side + "_label.png");
  std::set<int> seen;
  bool label_is_binary = true;
  int stray_px = 0;
  for (int v = 0; v < view.label.rows; ++v) {
    const uchar* ids = view.instance_ids.ptr(v);
    const uchar* label = view.label.ptr(v);
    for (int u = 0; u < view.label.cols; ++u) {
      if (ids[u] != 0) seen.insert(ids[u]);
      if (label[u] != 0 && label[u] != 255) label_is_binary = false;
      if (label[u] != 0 && ids[u] == 0) ++stray_px;
    }
  }
  std::set<int> known;
  bool all_hidden = true;
  for (const SceneObject& object : objects) {
    known.insert(object.id);
    all_hidden &= says_hidden(object, side);
    const cv::Mat mask = view.instance_ids == object.id;
    const int visible_px = cv::countNonZero(mask), label_px = cv::countNonZero(view.label & mask);
    check_count(object, "visible_px", side, visible_px, mask_file, problems);
    check_count(object, "label_px", side, label_px, label_file, problems);
    for (const char* key : {"visible_share", "visible_label_share"}) {
      check_share(object, key, side, scene / "scene.json", problems);
    }
    if (visible_px == 0) continue;
    DatasetSummary::ClassSummary& row = summary.classes[object.family];
    ++row.views;
    row.views_without_label += label_px == 0 ? 1 : 0;
    row.object_px += visible_px;
    row.label_px += label_px;
  }
  for (const int id : seen) {
    if (known.count(id) == 0) {
      problems.add(mask_file,
                   "holds id " + std::to_string(id) + ", expected only those that scene.json lists");
    }
  }
  if (seen.empty() && !objects.empty() && !all_hidden) {
    problems.add(mask_file, "is empty, expected the ids of the objects in scene.json");
  }
  if (!label_is_binary) problems.add(label_file, "holds other values, expected 0 and 255");
  if (stray_px > 0) {
    problems.add(label_file, "labels " + std::to_string(stray_px) +
                                 " px outside of every object, expected labels only where the mask is not 0");
  }
  return seen;
}

void check_scene(const fs::path& folder, const std::set<std::string>& families, Problems& problems,
                 DatasetSummary& summary) {
  const fs::path scene_json = folder / "scene.json";
  Json scene = Json::object();
  std::vector<SceneObject> objects;
  const bool is_scene_known = problems.collect([&] {
    scene = read_scene_json(scene_json);
    objects = scene_objects(scene, scene_json, problems);
    check_poses(scene, objects, scene_json, problems);
    check_axes(scene, scene_json, problems, summary);
    for (const SceneObject& object : objects) {
      ++summary.classes[object.family].objects;
      if (!families.empty() && families.count(object.family) == 0) {
        problems.add(scene_json, "object " + std::to_string(object.id) + " is of the family '" +
                                     object.family + "', expected one of those in dataset.json");
      }
    }
  });

  cv::Size size;
  std::set<int> seen;
  int complete_views = 0, left_channels = 0;
  for (const std::string side : {"left", "right"}) {
    problems.collect([&] {
      const fs::path image_file = folder / (side + ".png");
      require_8_bit(image_file);
      // Each file is read even if another one is broken: all that is wrong is to be named.
      SceneView view;
      bool is_complete = problems.collect([&] { view.image = read_image(image_file); });
      if (size.empty()) size = view.image.size();
      for (const char* kind : {"_mask.png", "_label.png"}) {
        const fs::path file = folder / (side + kind);
        cv::Mat& image = kind == std::string("_mask.png") ? view.instance_ids : view.label;
        is_complete &= problems.collect([&] {
          image = read_mask(file);
          if (!size.empty()) require_size(file, image, size);
        });
      }
      if (view.image.empty()) return;
      ++summary.images;
      if (left_channels == 0) left_channels = view.image.channels();
      require_size(image_file, view.image, size);
      if (view.image.channels() != left_channels) {
        problems.add(image_file, "is grey or colour, expected the same as the left image");
      }
      if (!is_complete || !is_scene_known) return;
      seen.merge(check_view_content(folder, side, view, objects, problems, summary));
      ++complete_views;
    });
  }
  if (complete_views == 2) {
    for (const SceneObject& object : objects) {
      if (seen.count(object.id) == 0 && member(*object.entry, "visible_px") == nullptr) {
        problems.add(scene_json, "object " + std::to_string(object.id) + " is in no mask");
      }
    }
  }
  if (!size.empty()) check_scene_size(scene, size, scene_json, problems);

  for (const char* name : {"left_depth.png", "right_depth.png"}) {
    const fs::path file = folder / name;
    std::error_code error;
    if (name == std::string("right_depth.png") && !fs::exists(file, error)) continue;  // optional
    problems.collect([&] {
      const cv::Mat depth = read_depth(file);
      if (!size.empty()) require_size(file, depth, size);
    });
  }
  problems.collect([&] {
    const fs::path file = folder / "calib.txt";
    const StereoCamera camera = load_calibration({file});
    const cv::Size calibrated(camera.width_px, camera.height_px);
    if (!size.empty() && calibrated != size) {
      problems.add(file, "is for images of " + size_text(calibrated) + " px, expected " + size_text(size) +
                             " like the left image");
    }
    check_camera(scene, camera, scene_json, file, problems);
  });
}

/// A user's mesh stands there as NAME@CHECKSUM, and is of the family NAME.
std::set<std::string> families_of(const Json& header) {
  std::set<std::string> families;
  const Json* list = member(header, "families");
  if (list == nullptr || !list->is_array()) return families;
  for (const Json& family : *list) {
    if (!family.is_string()) continue;
    const auto name = family.get<std::string>();
    families.insert(name.substr(0, name.find('@')));
  }
  return families;
}

}  // namespace

void check_graspctx_dataset(const fs::path& folder, Problems& problems, DatasetSummary& summary) {
  std::set<std::string> families;
  problems.collect([&] { families = families_of(read_dataset_header(folder)); });
  for (const fs::path& entry : sorted_entries(folder)) {
    std::error_code error;
    const bool lost_its_json = entry.extension() != ".partial" && fs::exists(entry / "left.png", error) &&
                               !fs::exists(entry / "scene.json", error);
    if (lost_its_json) problems.add(entry / "scene.json", "no such file, expected beside left.png");
  }
  problems.collect([&] {
    for (const fs::path& scene : scene_folders(folder)) {
      ++summary.scenes;
      check_scene(scene, families, problems, summary);
    }
  });
}

}  // namespace graspctx::detail
