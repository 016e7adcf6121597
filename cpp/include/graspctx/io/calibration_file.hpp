#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "graspctx/camera.hpp"
#include "graspctx/export.hpp"

namespace graspctx {

/// Load a calibration: one Middlebury calib.txt, or a ROS camera_info YAML pair (left, right).
/// A camera_info pair says that the images are raw unless it has no distortion, no rotation and the same
/// intrinsics before and after; with images_rectified they are taken as rectified already.
/// Throws InvalidInput naming the file.
GRASPCTX_EXPORT StereoCamera load_calibration(const std::vector<std::filesystem::path>& files,
                                              bool images_rectified = false);

}  // namespace graspctx
