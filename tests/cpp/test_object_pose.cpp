#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "graspctx/error.hpp"
#include "graspctx/object_pose.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::min(1.0, std::abs(a.normalized().dot(b.normalized())))) * 180 / 3.14159265358979;
}

std::optional<ObjectPose> pose_of(const CastScene& scene, int id, bool with_table, cv::Mat disparity = {}) {
  if (disparity.empty()) disparity = scene.disparity;
  const cv::Mat mask = scene.instance_ids == id;
  const auto fovea = foveal_pair(scene.pair, mask, disparity);
  if (!fovea) return std::nullopt;
  return estimate_object_pose(*fovea, mask, disparity, testing::test_camera(),
                              with_table ? std::optional(scene.table) : std::nullopt);
}

TEST(ObjectPose, AFlatPlateIsThePlaneOfItsThreePoints) {
  // A plate facing the camera obliquely; no table is given, so the plane comes from the points alone.
  const Eigen::Isometry3d cam_from_table = testing::look_at_table(0.7, 1.2);
  const CastScene scene = testing::cast_scene(testing::test_camera(),
                                              {Box{{0, 0, 0.004}, {0.09, 0.05, 0.004}, 0.4}}, cam_from_table);
  const auto pose = pose_of(scene, 1, false);
  ASSERT_TRUE(pose);
  EXPECT_LT(angle_deg(pose->normal, cam_from_table.linear().col(2)), 12);
  EXPECT_LT(pose->normal.dot(pose->centroid_m), 0);  // towards the camera
  EXPECT_NEAR(pose->normal.norm(), 1, 1e-12);
}

TEST(ObjectPose, ALowObjectLiesOnTheTable) {
  const double turn = 0.5;
  const CastScene scene =
      testing::cast_scene(testing::test_camera(), {Box{{0.02, 0.01, 0.004}, {0.075, 0.006, 0.004}, turn}});
  const auto pose = pose_of(scene, 1, true);
  ASSERT_TRUE(pose);
  const Eigen::Vector3d along =
      scene.cam_from_table.linear() * Eigen::Vector3d(std::cos(turn), std::sin(turn), 0);
  EXPECT_LT(angle_deg(pose->major_axis_m, along), 3);
  EXPECT_NEAR(pose->major_axis_m.norm(), 0.075, 0.006);
  EXPECT_LT(angle_deg(pose->normal, scene.table.normal), 1e-6);
  EXPECT_LT((pose->centroid_m - scene.cam_from_table * Eigen::Vector3d(0.02, 0.01, 0.006)).norm(), 0.006);
}

TEST(ObjectPose, ATallObjectStandsUpright) {
  const CastScene scene =
      testing::cast_scene(testing::test_camera(), {Box{{0, 0, 0.08}, {0.025, 0.025, 0.08}, 0.3}});
  const auto pose = pose_of(scene, 1, true);
  ASSERT_TRUE(pose);
  const Eigen::Vector3d up = scene.cam_from_table.linear().col(2);
  EXPECT_LT(angle_deg(pose->major_axis_m, up), 1e-6);
  EXPECT_NEAR(std::abs(pose->normal.dot(up)), 0, 1e-9);
  EXPECT_NEAR(std::abs(pose->minor_axis_m.dot(up)), 0, 1e-9);
  EXPECT_NEAR(pose->major_axis_m.norm(), 0.08, 0.025);
}

TEST(ObjectPose, MatchesAreBetterThanTheRoughDisparity) {
  const CastScene scene =
      testing::cast_scene(testing::test_camera(), {Box{{0, 0, 0.04}, {0.05, 0.04, 0.04}, 0.2}});
  const auto truth = pose_of(scene, 1, true);
  cv::Mat off = scene.disparity + 0.8;  // a rough disparity, still within reach of the match
  const auto found = pose_of(scene, 1, true, off);
  ASSERT_TRUE(truth && found);
  EXPECT_LT((truth->centroid_m - found->centroid_m).norm(), 0.002);
}

TEST(ObjectPose, SaysWhenAPointCouldNotBeMatched) {
  CastScene scene =
      testing::cast_scene(testing::test_camera(), {Box{{0, 0, 0.004}, {0.09, 0.05, 0.004}, 0.4}},
                          testing::look_at_table(0.7, 1.2));
  EXPECT_EQ(pose_of(scene, 1, true)->source, ObjectPose::Source::stereo);
  scene.pair.left.setTo(cv::Scalar(120, 120, 120), scene.instance_ids);  // a textureless side
  const auto pose = pose_of(scene, 1, true);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->source, ObjectPose::Source::segment_depth);
  EXPECT_LT((pose->centroid_m - scene.cam_from_table * Eigen::Vector3d(0, 0, 0.008)).norm(), 0.01);
}

TEST(ObjectPose, NothingWithoutDepth) {
  const CastScene scene =
      testing::cast_scene(testing::test_camera(), {Box{{0, 0, 0.04}, {0.05, 0.04, 0.04}, 0.2}});
  const cv::Mat mask = scene.instance_ids == 1;
  const auto fovea = foveal_pair(scene.pair, mask, scene.disparity);
  const cv::Mat unknown(mask.size(), CV_32FC1, cv::Scalar(std::nanf("")));
  EXPECT_FALSE(estimate_object_pose(*fovea, mask, unknown, testing::test_camera(), scene.table));
  EXPECT_FALSE(estimate_object_pose(*fovea, cv::Mat::zeros(mask.size(), CV_8UC1), scene.disparity,
                                    testing::test_camera(), scene.table));
  EXPECT_THROW(estimate_object_pose(*fovea, cv::Mat::zeros(3, 3, CV_8UC1), scene.disparity,
                                    testing::test_camera(), scene.table),
               InvalidInput);
}

}  // namespace
}  // namespace graspctx
