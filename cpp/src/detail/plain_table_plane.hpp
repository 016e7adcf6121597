#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "detail/outline_match.hpp"
#include "graspctx/camera.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

/// The plane of a support without texture, from the outline of its plain region: the support's border, the
/// outlines of shadows, and where objects touch it lie on the plane; outlines of objects lie above it, and
/// nothing below. Nothing unless the matches tell its angle and its height well: on how many outlines a plane
/// can be found at all depends on the scene, and a wrong plane is worse than none.
/// centre_px: where on the support the height has to be right. is_support: which planes may be a table.
std::optional<TablePlane> plane_under_outline(const std::vector<OutlineMatch>& outline,
                                              const StereoCamera& camera, const Eigen::Vector2d& centre_px,
                                              const std::function<bool(const TablePlane&)>& is_support);

/// The same where the normal is known, from the floor beneath or from gravity: only the height is left. The
/// angle is as right as the normal that is given.
std::optional<TablePlane> level_plane_under_outline(const std::vector<OutlineMatch>& outline,
                                                    const StereoCamera& camera,
                                                    const Eigen::Vector3d& normal);

}  // namespace graspctx::detail
