#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

namespace graspctx::detail {

inline constexpr std::size_t max_coco_bytes = std::size_t{1} << 28;

/// What a JSON file looks like, by the lists at its top.
enum class AnnotationKind { none, labelme, coco };
/// Throws InvalidInput if it is no JSON.
AnnotationKind annotation_kind(const std::filesystem::path& file);

/// The COCO file of a data set: the path itself if it is a file, or the only one in the folder or in its
/// annotations/. Throws InvalidInput if there is none, or more.
std::filesystem::path find_coco_file(const std::filesystem::path& path);

/// Where an image of a COCO file is: in the data set's folder or its images/, there or in the sub-folder of
/// the subset that annotations/instances_SUBSET.json names. The data set's folder holds the file, or the
/// annotations/ that it is in. Throws InvalidInput if it is in none of them or not inside of the folder.
std::filesystem::path coco_image_file(const std::filesystem::path& file, const std::string& name);

}  // namespace graspctx::detail
