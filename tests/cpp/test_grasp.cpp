#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "graspctx/error.hpp"
#include "graspctx/grasp.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

/// An object seen straight on: major axis to the right in the image, minor axis down.
ObjectPose straight_pose() {
  ObjectPose pose;
  pose.centroid_m = {0, 0, 0.6};
  pose.major_axis_m = {0.08, 0, 0};
  pose.minor_axis_m = {0, 0.03, 0};
  pose.normal = {0, 0, -1};
  pose.centroid_px = {320, 240};
  pose.major_px = {400, 240};
  pose.minor_px = {320, 270};
  return pose;
}

TEST(ApproachAndWrist, FollowsTheThreeCasesOfEquation3) {
  const ObjectPose pose = straight_pose();
  const auto middle = approach_and_wrist({322, 243}, pose);
  EXPECT_EQ(middle.rule, ApproachRule::plane_normal);
  EXPECT_LT((middle.approach - Eigen::Vector3d(0, 0, 1)).norm(), 1e-12);  // away from the camera
  EXPECT_NEAR(std::abs(middle.closing.y()), 1, 1e-12);                    // across the object: a_mi

  const auto right = approach_and_wrist({390, 245}, pose);
  EXPECT_EQ(right.rule, ApproachRule::major_axis);
  EXPECT_LT((right.approach - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-12);  // from outside, i.e. from the right
  EXPECT_NEAR(std::abs(right.closing.z()), 1, 1e-12);                     // n_p
  const auto left = approach_and_wrist({250, 245}, pose);
  EXPECT_LT((left.approach - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);

  const auto below = approach_and_wrist({322, 268}, pose);
  EXPECT_EQ(below.rule, ApproachRule::minor_axis);
  EXPECT_LT((below.approach - Eigen::Vector3d(0, -1, 0)).norm(), 1e-12);
  EXPECT_NEAR(std::abs(below.closing.z()), 1, 1e-12);
}

TEST(ApproachAndWrist, DoesNotDependOnTheSenseOfAnAxis) {
  std::mt19937 generator(8);
  for (int i = 0; i < 200; ++i) {
    const ObjectPose pose = straight_pose();
    ObjectPose flipped = pose;
    flipped.major_axis_m = -pose.major_axis_m;
    flipped.major_px = 2 * pose.centroid_px - pose.major_px;
    const Eigen::Vector2d at(testing::uniform(generator, 230, 410), testing::uniform(generator, 205, 275));
    const auto one = approach_and_wrist(at, pose), other = approach_and_wrist(at, flipped);
    EXPECT_EQ(one.rule, other.rule);
    EXPECT_LT((one.approach - other.approach).norm(), 1e-12);
  }
}

TEST(ApproachAndWrist, IsOrthonormalForSkewedAxes) {
  ObjectPose pose = straight_pose();
  pose.minor_axis_m = {0.01, 0.03, 0.01};
  pose.normal = Eigen::Vector3d(0.2, 0.1, -1).normalized();
  for (const auto rule : {ApproachRule::plane_normal, ApproachRule::major_axis, ApproachRule::minor_axis}) {
    const auto wrist = approach_by_rule(rule, {350, 250}, pose);
    EXPECT_NEAR(wrist.approach.norm(), 1, 1e-12);
    EXPECT_NEAR(wrist.closing.norm(), 1, 1e-12);
    EXPECT_NEAR(wrist.approach.dot(wrist.closing), 0, 1e-12);
  }
}

/// A table 0.7 m below a camera that looks straight down at it.
TablePlane table_below() {
  TablePlane table;
  table.normal = {0, 0, -1};
  table.offset_m = 0.7;
  return table;
}

Eigen::Matrix4d hand_at(const Eigen::Vector3d& approach, const Eigen::Vector3d& closing,
                        const Eigen::Vector3d& at) {
  Eigen::Matrix4d cam_from_hand = Eigen::Matrix4d::Identity();
  cam_from_hand.block<3, 1>(0, 0) = closing;
  cam_from_hand.block<3, 1>(0, 1) = approach.cross(closing);
  cam_from_hand.block<3, 1>(0, 2) = approach;
  cam_from_hand.block<3, 1>(0, 3) = at;
  return cam_from_hand;
}

TEST(TableConflict, ComesFromAboveButNotFromBelow) {
  const TablePlane table = table_below();
  const Eigen::Vector3d down(0, 0, 1), up(0, 0, -1), right(1, 0, 0);
  EXPECT_FALSE(table_conflict(hand_at(down, right, {0, 0, 0.65}), 0.05, table));
  EXPECT_FALSE(
      table_conflict(hand_at(down, right, {0, 0, 0.6965}), 0.05, table));  // a pencil's middle, 3.5 mm up
  EXPECT_TRUE(table_conflict(hand_at(down, right, {0, 0, 0.6999}), 0.05, table));  // in the table
  EXPECT_TRUE(table_conflict(hand_at(up, right, {0, 0, 0.65}), 0.05, table));
  // From the side the palm needs room: its radius, and the fingers' spread.
  EXPECT_FALSE(table_conflict(hand_at(right, Eigen::Vector3d::UnitY(), {0, 0, 0.60}), 0.05, table));
  EXPECT_TRUE(table_conflict(hand_at(right, Eigen::Vector3d::UnitY(), {0, 0, 0.68}), 0.05, table));
}

TEST(TableConflict, RisesMonotonically) {
  // Whatever the hand's direction: once clear, higher is clear too.
  std::mt19937 generator(9);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d approach =
        Eigen::Vector3d(testing::uniform(generator, -1, 1), testing::uniform(generator, -1, 1),
                        testing::uniform(generator, -1, 1))
            .normalized();
    const Eigen::Vector3d closing = approach.unitOrthogonal();
    bool was_clear = false;
    for (double height_m = 0.002; height_m < 0.4; height_m += 0.002) {
      const bool clear =
          !table_conflict(hand_at(approach, closing, {0, 0, 0.7 - height_m}), 0.06, table_below());
      EXPECT_TRUE(clear || !was_clear);
      was_clear = clear;
    }
    EXPECT_TRUE(was_clear);
  }
}

TEST(ConfigureGrasp, FallsThroughToAnotherCaseWhereTheTableIsInTheWay) {
  // A standing stem, its foot on the table: along the major axis the hand would have to come from below.
  const StereoCamera camera = testing::test_camera();
  cv::Mat mask = cv::Mat::zeros(480, 640, CV_8UC1);
  cv::rectangle(mask, cv::Rect(310, 120, 20, 240), cv::Scalar(255), cv::FILLED);
  ObjectPose pose;
  pose.centroid_m = {0, 0, 0.6};
  pose.major_axis_m = {0, 0.12, 0};
  pose.minor_axis_m = {0.01, 0, 0};
  pose.normal = {0, 0, -1};
  pose.centroid_px = {319.5, 239.5};
  pose.major_px = {319.5, 359.5};
  pose.minor_px = {329.5, 239.5};
  TablePlane table;
  table.normal = {0, -1, 0};
  table.offset_m = 0.125;
  StereoMatch match;
  match.disparity_px = camera.disparity_px(0.6);
  match.disparity_stddev_px = 0.2;
  const Eigen::Vector2d at(319.5, 280);
  EXPECT_EQ(approach_and_wrist(at, pose).rule, ApproachRule::major_axis);
  const GraspConfiguration grasp = configure_grasp(at, match, mask, camera, pose, table);
  EXPECT_TRUE(grasp.feasible);
  EXPECT_EQ(grasp.rule, ApproachRule::minor_axis);
  EXPECT_NEAR(grasp.approach.y(), 0, 1e-12);
  // The part is 20 px wide, 2 cm at 0.6 m: the middle lies 1 cm behind the surface, the hand opens 2 + 2·2
  // cm.
  EXPECT_NEAR(grasp.position_m.z(), 0.61, 0.001);
  EXPECT_NEAR(grasp.opening_m, 0.06, 0.002);
  EXPECT_GT(grasp.position_stddev_m.z(), 0);
  const Eigen::Matrix3d rotation = grasp.cam_from_hand.block<3, 3>(0, 0);
  EXPECT_NEAR(rotation.determinant(), 1, 1e-9);
  EXPECT_LT((rotation.col(2) - grasp.approach).norm(), 1e-12);
  EXPECT_LT((rotation.col(0) - grasp.closing).norm(), 1e-12);
  EXPECT_FALSE(configure_grasp(at, match, mask, camera, pose, std::nullopt).infeasible_because);
}

TEST(ConfigureGrasp, NoPartReachesBelowTheTable) {
  // A pencil, 20 px or 2 cm wide here, whose disparity puts it 1 cm into the table it lies on.
  const StereoCamera camera = testing::test_camera();
  cv::Mat mask = cv::Mat::zeros(480, 640, CV_8UC1);
  cv::rectangle(mask, cv::Rect(220, 230, 200, 20), cv::Scalar(255), cv::FILLED);
  ObjectPose pose = straight_pose();
  pose.centroid_m.z() = 0.7;
  StereoMatch match;
  match.disparity_px = camera.disparity_px(0.7);
  const GraspConfiguration grasp = configure_grasp({320, 239.5}, match, mask, camera, pose, table_below());
  EXPECT_NEAR(table_below().height_m(grasp.position_m), grasp.opening_m / 2 - HandOptions().opening_margin_m,
              1e-4);
  EXPECT_EQ(grasp.rule, ApproachRule::plane_normal);
  EXPECT_TRUE(grasp.feasible) << grasp.infeasible_because.value_or("");
  EXPECT_LT((camera.project(grasp.position_m) - grasp.left_px).norm(), 1e-9);
}

TEST(ConfigureGrasp, SaysWhenThePartIsTooWide) {
  const StereoCamera camera = testing::test_camera();
  const cv::Mat mask(480, 640, CV_8UC1, cv::Scalar(255));
  StereoMatch match;
  match.disparity_px = camera.disparity_px(0.6);
  const GraspConfiguration grasp =
      configure_grasp({320, 240}, match, mask, camera, straight_pose(), std::nullopt);
  EXPECT_FALSE(grasp.feasible);
  ASSERT_TRUE(grasp.infeasible_because);
  EXPECT_NE(grasp.infeasible_because->find("wider"), std::string::npos);
}

}  // namespace
}  // namespace graspctx
