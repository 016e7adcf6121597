#pragma once
// A stereo pair of known geometry: boxes with a solid texture on a table, by casting one ray for each pixel.
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "graspctx/camera.hpp"
#include "graspctx/segmentation.hpp"
#include "graspctx/stereo.hpp"

namespace graspctx::testing {

struct Box {
  Eigen::Vector3d centre_m, half_m;  // in the table frame: z up, the table at z = 0
  double turn_rad = 0;               // about z
  Eigen::Vector3d colour{90, 120, 200};
};

struct CastScene {
  RectifiedPair pair;
  cv::Mat instance_ids;  // of the left view
  cv::Mat disparity;     // CV_32FC1 px, true
  TablePlane table;      // true
  Eigen::Isometry3d cam_from_table;
};

/// The table ends there, and a floor lies below it.
struct TableEdges {
  Eigen::Vector2d low_m = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity()),
                  high_m = -low_m;
  double floor_m = -0.5;
};

/// A camera looking down on the table's origin from a distance, tilted by an elevation.
inline Eigen::Isometry3d look_at_table(double distance_m = 0.7, double elevation_rad = 0.7,
                                       double roll_rad = 0.05) {
  const Eigen::Vector3d eye =
      distance_m * Eigen::Vector3d(0, -std::cos(elevation_rad), std::sin(elevation_rad));
  const Eigen::Vector3d z = -eye.normalized(), x = Eigen::Vector3d::UnitX();
  Eigen::Matrix3d table_from_cam;
  table_from_cam << x, z.cross(x), z;
  table_from_cam = table_from_cam * Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = table_from_cam;
  result.translation() = eye;
  return result.inverse();
}

/// Value noise in three dimensions, in [−1, 1]: a solid texture looks the same from both cameras.
inline double solid_noise(const Eigen::Vector3d& point_m, double cell_m, std::uint32_t seed) {
  const Eigen::Vector3d p = point_m / cell_m, floor = p.array().floor(), f = p - floor;
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d offset(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    std::uint32_t hash = seed;
    for (int axis = 0; axis < 3; ++axis) {
      hash = (hash ^ static_cast<std::uint32_t>(static_cast<int>(floor[axis] + offset[axis]))) * 0x9E3779B1u;
      hash ^= hash >> 15;
    }
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= offset[axis] > 0 ? f[axis] : 1 - f[axis];
    sum += weight * ((hash * 0x85EBCA77u >> 8) / 8388608.0 - 1);
  }
  return sum;
}

/// table_contrast: of the table's texture, grey levels; plain_box: the number of a box without texture,
/// from 1.
inline CastScene cast_scene(const StereoCamera& camera, const std::vector<Box>& boxes,
                            const Eigen::Isometry3d& cam_from_table = look_at_table(),
                            const TableEdges& edges = {}, double table_contrast = 60, int plain_box = 0) {
  const cv::Size size(camera.width_px, camera.height_px);
  CastScene scene;
  scene.cam_from_table = cam_from_table;
  scene.instance_ids = cv::Mat::zeros(size, CV_8UC1);
  scene.disparity = cv::Mat(size, CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  scene.table.normal = cam_from_table.linear().col(2);
  scene.table.offset_m = -scene.table.normal.dot(cam_from_table.translation());
  // d = f·B/Z − doffs, with 1/Z linear in the pixel on the plane.
  const double s = -camera.focal_px * camera.baseline_m / scene.table.offset_m;
  scene.table.alpha = s * scene.table.normal.x() / camera.focal_px;
  scene.table.beta = s * scene.table.normal.y() / camera.focal_px;
  scene.table.delta_px = s * scene.table.normal.z() - camera.doffs_px -
                         scene.table.alpha * camera.centre_px.x() - scene.table.beta * camera.centre_px.y();

  const Eigen::Isometry3d table_from_cam = cam_from_table.inverse();
  for (const bool left : {true, false}) {
    cv::Mat image(size, CV_8UC3, cv::Scalar(170, 160, 150));
    const Eigen::Vector3d eye_cam(left ? 0 : camera.baseline_m, 0, 0);
    const Eigen::Vector3d eye = table_from_cam * eye_cam;
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const double centre_u = camera.centre_px.x() + (left ? 0 : camera.doffs_px);
        const Eigen::Vector3d ray =
            table_from_cam.linear() * Eigen::Vector3d((u - centre_u) / camera.focal_px,
                                                      (v - camera.centre_px.y()) / camera.focal_px,
                                                      1);  // Z = 1
        double nearest = ray.z() < 0 ? -eye.z() / ray.z() : std::numeric_limits<double>::infinity();
        const Eigen::Array2d at = (eye + nearest * ray).head<2>();
        if ((at < edges.low_m.array() || at > edges.high_m.array()).any()) {
          nearest = ray.z() < 0 ? (edges.floor_m - eye.z()) / ray.z() : nearest;
        }
        int hit = 0;
        for (std::size_t b = 0; b < boxes.size(); ++b) {
          const Eigen::AngleAxisd turn(-boxes[b].turn_rad, Eigen::Vector3d::UnitZ());
          const Eigen::Vector3d o = turn * (eye - boxes[b].centre_m), d = turn * ray;
          double enter = 0, leave = std::numeric_limits<double>::infinity();
          for (int axis = 0; axis < 3; ++axis) {
            const double t0 = (-boxes[b].half_m[axis] - o[axis]) / d[axis];
            const double t1 = (boxes[b].half_m[axis] - o[axis]) / d[axis];
            enter = std::max(enter, std::min(t0, t1));
            leave = std::min(leave, std::max(t0, t1));
          }
          if (enter < leave && enter > 0 && enter < nearest) {
            nearest = enter;
            hit = static_cast<int>(b) + 1;
          }
        }
        if (!std::isfinite(nearest) || nearest > 5) continue;
        const Eigen::Vector3d point = eye + nearest * ray;
        const double noise = 0.6 * solid_noise(point, 0.006, 7u + static_cast<unsigned>(hit)) +
                             0.4 * solid_noise(point, 0.02, 70u + static_cast<unsigned>(hit));
        const Eigen::Vector3d base =
            hit ? boxes[static_cast<std::size_t>(hit) - 1].colour : Eigen::Vector3d(150, 150, 140);
        const double contrast = hit == 0 ? table_contrast : hit == plain_box ? 0 : 60;
        const Eigen::Vector3d colour = base + Eigen::Vector3d::Constant(contrast * noise);
        for (int c = 0; c < 3; ++c) image.at<cv::Vec3b>(v, u)[c] = cv::saturate_cast<uchar>(colour[c]);
        if (left) {
          scene.instance_ids.at<uchar>(v, u) = static_cast<uchar>(hit);
          scene.disparity.at<float>(v, u) = static_cast<float>(camera.disparity_px(nearest));
        }
      }
    }
    (left ? scene.pair.left : scene.pair.right) = image;
  }
  return scene;
}

}  // namespace graspctx::testing
