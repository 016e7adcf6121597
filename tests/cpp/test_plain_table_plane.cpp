#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <random>

#include "detail/plain_table_plane.hpp"
#include "detail/plane_geometry.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using detail::OutlineMatch;
using testing::Box;
using testing::CastScene;

const StereoCamera camera = testing::test_camera();
const Eigen::Vector2d centre_px(320, 300);

TablePlane true_table() {
  const Eigen::Isometry3d cam_from_table = testing::look_at_table();
  const Eigen::Vector3d normal = cam_from_table.linear().col(2);
  return detail::plane_in_view(normal, -normal.dot(cam_from_table.translation()), camera);
}

bool any_plane(const TablePlane& plane) {
  return plane.normal.allFinite() && plane.normal.z() < -0.1;
}

double angle_deg(const TablePlane& a, const TablePlane& b) {
  return std::acos(std::min(1.0, a.normal.dot(b.normal))) * 180 / CV_PI;
}

double height_apart_m(const TablePlane& a, const TablePlane& b) {
  const double d = detail::plane_disparity(b, centre_px.x(), centre_px.y());
  return std::abs(detail::height_m(a, camera, centre_px.x(), centre_px.y(), d));
}

/// Matches along a line of the image, one for each row, this far (px of disparity) above the table.
void add_line(std::vector<OutlineMatch>& outline, const cv::Point2d& from, const cv::Point2d& to,
              double above_px, double rising_px = 0) {
  static std::mt19937 generator(5);
  const TablePlane table = true_table();
  const int rows = static_cast<int>(std::abs(to.y - from.y));
  for (int i = 0; i < rows; ++i) {
    const double t = double(i) / rows, u = from.x + t * (to.x - from.x), v = from.y + t * (to.y - from.y);
    const double noise = 0.05 * (testing::uniform(generator) + testing::uniform(generator) - 1);
    outline.push_back({u, v, detail::plane_disparity(table, u, v) + above_px + t * rising_px + noise, 0.05});
  }
}

TEST(PlainTablePlane, LiesUnderItsOutline) {
  std::vector<OutlineMatch> outline;
  add_line(outline, {40, 450}, {120, 150}, 0);   // the table's border
  add_line(outline, {600, 440}, {500, 150}, 0);  // and its other one
  add_line(outline, {300, 330}, {350, 370}, 0);  // a shadow
  // More of it stands on the table than is seen of the table itself.
  for (const double u : {220.0, 260.0, 330.0, 380.0}) add_line(outline, {u, 320}, {u, 120}, 0, 14);
  const auto plane = detail::plane_under_outline(outline, camera, centre_px, any_plane);
  ASSERT_TRUE(plane);
  EXPECT_LT(angle_deg(*plane, true_table()), 0.3);
  EXPECT_LT(height_apart_m(*plane, true_table()), 0.001);
}

TEST(PlainTablePlane, IsNotGuessed) {
  std::vector<OutlineMatch> border;
  add_line(border, {40, 450}, {120, 150}, 0);
  EXPECT_FALSE(detail::plane_under_outline({}, camera, centre_px, any_plane));
  // Many planes run through one line.
  EXPECT_FALSE(detail::plane_under_outline(border, camera, centre_px, any_plane));
  // A small shadow beside one object says something of the height, and nothing of the angle.
  std::vector<OutlineMatch> shadow;
  add_line(shadow, {300, 300}, {310, 330}, 0);
  add_line(shadow, {330, 300}, {318, 330}, 0);
  EXPECT_FALSE(detail::plane_under_outline(shadow, camera, centre_px, any_plane));
  const auto level = detail::level_plane_under_outline(shadow, camera, true_table().normal);
  ASSERT_TRUE(level);
  EXPECT_LT(height_apart_m(*level, true_table()), 0.001);
  // Among the outlines of one object, which are at all heights, some are level with it anywhere.
  std::vector<OutlineMatch> object;
  add_line(object, {280, 300}, {270, 100}, 0, 20);
  add_line(object, {350, 300}, {360, 100}, 0, 20);
  add_line(object, {320, 330}, {340, 310}, 5);
  EXPECT_FALSE(detail::level_plane_under_outline(object, camera, true_table().normal));
}

TEST(PlainTablePlane, IsNotSeenInABlur) {
  std::vector<OutlineMatch> outline;
  add_line(outline, {40, 450}, {120, 150}, 0);
  add_line(outline, {600, 440}, {500, 150}, 0);
  ASSERT_TRUE(detail::plane_under_outline(outline, camera, centre_px, any_plane));
  std::mt19937 generator(3);
  for (OutlineMatch& match : outline) match.disparity_px += testing::uniform(generator, -0.8, 0.8);
  EXPECT_FALSE(detail::plane_under_outline(outline, camera, centre_px, any_plane));
}

TEST(PlainTablePlane, ATableOverATexturedFloorIsNotTheFloor) {
  // A plain table, and beside it a textured floor 60 cm below.
  const Eigen::Isometry3d cam_from_table = testing::look_at_table(0.8, 0.8, 0.05);
  const Box table{{0, 0, 0.598}, {0.32, 0.25, 0.002}, 0.5, {225, 240, 235}};
  const Box book{{0.05, 0, 0.63}, {0.06, 0.04, 0.03}, 0.9, {60, 90, 200}};
  const Box box{{-0.12, 0.05, 0.62}, {0.03, 0.03, 0.02}, 0.2, {190, 120, 60}};
  Eigen::Isometry3d floor = Eigen::Isometry3d::Identity();
  floor.translation().z() = -0.6;
  CastScene scene = testing::cast_scene(camera, {table, book, box}, cam_from_table * floor, {}, 60, 1);
  testing::add_noise(scene.pair, 1);
  const auto plane = fit_table_plane(scene.pair, compute_disparity(scene.pair), camera);
  const TablePlane truth = detail::plane_in_view(scene.table.normal, scene.table.offset_m - 0.6, camera);
  ASSERT_TRUE(plane);
  EXPECT_LT(angle_deg(*plane, truth), 2);
  EXPECT_LT(height_apart_m(*plane, truth), 0.01);  // and not 0.6
}

TEST(PlainTablePlane, ItsBorderTellsItHoweverItSlants) {
  // A corner of the table away from the camera: its sides run down at 20 to 30 degrees. The floor is as
  // plain.
  const Eigen::Isometry3d cam_from_table = testing::look_at_table(0.8, 0.45, 0.03);
  const Box table{{0, -0.1, 0.598}, {0.3, 0.3, 0.002}, 0.85, {225, 240, 235}};
  const Box box{{0.05, -0.05, 0.61}, {0.04, 0.03, 0.01}, 0.3, {190, 120, 60}};
  Eigen::Isometry3d floor = Eigen::Isometry3d::Identity();
  floor.translation().z() = -0.6;
  CastScene scene = testing::cast_scene(camera, {table, box}, cam_from_table * floor, {}, 0, 1);
  testing::add_noise(scene.pair, 1);
  const auto plane = fit_table_plane(scene.pair, compute_disparity(scene.pair), camera);
  const TablePlane truth = detail::plane_in_view(scene.table.normal, scene.table.offset_m - 0.6, camera);
  ASSERT_TRUE(plane);
  EXPECT_LT(angle_deg(*plane, truth), 1);
  EXPECT_LT(height_apart_m(*plane, truth), 0.004);
}

TEST(PlainTablePlane, AnEmptyPlainTableHasNone) {
  CastScene scene = testing::cast_scene(camera, {}, testing::look_at_table(), {}, 0);
  testing::add_noise(scene.pair, 1);
  EXPECT_FALSE(fit_table_plane(scene.pair, compute_disparity(scene.pair), camera));
}

}  // namespace
}  // namespace graspctx
