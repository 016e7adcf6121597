#include "coco_file.hpp"

#include <system_error>
#include <vector>

#include "dataset_reader.hpp"
#include "json_file.hpp"

namespace graspctx::detail {

namespace fs = std::filesystem;

AnnotationKind annotation_kind(const fs::path& file) {
  const Json json = read_json_object(file, max_coco_bytes);
  const auto has_list = [&](const char* key) {
    const Json* list = member(json, key);
    return list != nullptr && list->is_array();
  };
  if (has_list("shapes")) return AnnotationKind::labelme;
  return has_list("images") && has_list("annotations") ? AnnotationKind::coco : AnnotationKind::none;
}

fs::path find_coco_file(const fs::path& path) {
  if (!is_folder(path)) return path;
  std::vector<fs::path> found;
  std::vector<std::string> names, unreadable;
  for (const fs::path& folder : {path, path / "annotations"}) {
    if (!is_folder(folder)) continue;
    for (const fs::path& file : sorted_entries(folder)) {
      if (file.extension() != ".json") continue;
      try {
        if (annotation_kind(file) != AnnotationKind::coco) continue;
        found.push_back(file);
        names.push_back(file.lexically_relative(path).string());
      } catch (const InvalidInput& error) {
        unreadable.emplace_back(error.what());
      }
    }
  }
  if (found.size() > 1) fail(path, "holds several COCO files, expected the name of one: " + joined(names));
  if (found.empty() && !unreadable.empty()) throw InvalidInput(unreadable.front());
  if (found.empty()) fail(path, "holds no COCO file, expected one here or in annotations/");
  return found.front();
}

fs::path coco_image_file(const fs::path& file, const std::string& name) {
  const bool is_in_annotations = fs::absolute(file).parent_path().filename() == "annotations";
  const fs::path folder = is_in_annotations ? file.parent_path() / ".." : file.parent_path();
  const fs::path root = folder.empty() ? fs::path(".") : folder.lexically_normal();
  const std::string stem = file.stem().string(), start = "instances_";
  const bool has_subset = stem.compare(0, start.size(), start) == 0 && stem.size() > start.size();
  const std::string subset = has_subset ? stem.substr(start.size()) : ".";
  for (const fs::path& place : {root, root / "images", root / subset, root / "images" / subset}) {
    const fs::path image = path_inside(place.lexically_normal(), name, file);
    std::error_code error;
    if (fs::exists(image, error)) return image;
  }
  fail(path_inside(root, name, file),
       "no such file, expected the image that " + file.string() + " names" + ", here or in images/");
}

}  // namespace graspctx::detail
