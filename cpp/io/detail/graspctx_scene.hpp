#pragma once
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "json_file.hpp"
#include "problems.hpp"

// The parts of the project's own layout (docs/dataset-format.md) that training and checking both read.
namespace graspctx::detail {

/// dataset.json. Throws InvalidInput unless it is one of the version that is read here.
Json read_dataset_header(const std::filesystem::path& folder);

/// In the order of their names. A scene that is being written ends in .partial.
std::vector<std::filesystem::path> scene_folders(const std::filesystem::path& folder);

/// scene.json. Throws InvalidInput unless its schema is the one that is read here.
Json read_scene_json(const std::filesystem::path& scene_json);

struct SceneObject {
  int id = 0;
  std::string family;
  const Json* entry = nullptr;  // all that scene.json says of it
};
/// The objects that scene.json lists; those that lack an id or a family, or repeat an id, are problems.
std::vector<SceneObject> scene_objects(const Json& scene, const std::filesystem::path& scene_json,
                                       Problems& problems);

struct SceneView {
  cv::Mat image, instance_ids, label;
};
/// side: "left" or "right". Throws InvalidInput naming the file.
SceneView read_scene_view(const std::filesystem::path& scene, const std::string& side);

}  // namespace graspctx::detail
