#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "graspctx/error.hpp"
#include "graspctx/segmentation.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;

constexpr double degree = CV_PI / 180;
const Box tall_box{{-0.08, 0.03, 0.05}, {0.03, 0.02, 0.05}, 0.4, {60, 90, 200}};
const Box flat_box{{0.09, 0.02, 0.02}, {0.05, 0.035, 0.02}, -0.3, {190, 120, 60}};

CastScene make_scene(const std::vector<Box>& boxes,
                     const Eigen::Isometry3d& cam_from_table = testing::look_at_table()) {
  CastScene scene = testing::cast_scene(testing::test_camera(), boxes, cam_from_table);
  testing::add_noise(scene.pair, 1);
  return scene;
}

/// Casting takes its time: the scene that most tests look at.
const CastScene& two_boxes() {
  static const CastScene scene = make_scene({tall_box, flat_box});
  return scene;
}

std::optional<TablePlane> fit(const RectifiedPair& pair, const SegmentationOptions& options = {}) {
  return fit_table_plane(pair, compute_disparity(pair), testing::test_camera(), options);
}

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::min(1.0, a.dot(b))) / degree;
}

TEST(TablePlane, IsFoundToATenthOfADegreeAndAMillimetre) {
  const CastScene& scene = two_boxes();
  const auto plane = fit_table_plane(scene.pair, compute_disparity(scene.pair), testing::test_camera());
  ASSERT_TRUE(plane);
  EXPECT_LT(angle_deg(plane->normal, scene.table.normal), 0.1);
  EXPECT_NEAR(plane->normal.norm(), 1, 1e-12);
  EXPECT_NEAR(plane->height_m(scene.cam_from_table * Eigen::Vector3d(0, 0, 0)), 0, 0.0005);
  EXPECT_NEAR(plane->height_m(scene.cam_from_table * Eigen::Vector3d(0.1, -0.1, 0.05)), 0.05, 0.001);
  // The image's form of it is the same plane.
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(100, 150), Eigen::Vector2d(500, 400)}) {
    const double d = plane->alpha * pixel.x() + plane->beta * pixel.y() + plane->delta_px;
    EXPECT_NEAR(plane->height_m(testing::test_camera().triangulate(pixel, d)), 0, 1e-9);
  }
  EXPECT_GT(plane->sigma_px, 0);
  EXPECT_LT(plane->sigma_px, 1);
}

TEST(TablePlane, HoldsForCamerasWhosePrincipalPointsDiffer) {
  // The right view moved by some pixels and doffs with it is the same scene.
  const CastScene& scene = two_boxes();
  constexpr int moved_px = 12;
  StereoCamera camera = testing::test_camera();
  camera.doffs_px = moved_px;
  RectifiedPair pair{scene.pair.left, {}};
  cv::warpAffine(scene.pair.right, pair.right, cv::Matx23d(1, 0, moved_px, 0, 1, 0), pair.right.size());
  const auto plane = fit_table_plane(pair, compute_disparity(pair), camera);
  ASSERT_TRUE(plane);
  EXPECT_LT(angle_deg(plane->normal, scene.table.normal), 0.1);
  EXPECT_NEAR(plane->offset_m, scene.table.offset_m, 0.001);
}

TEST(TablePlane, OfTableAndFloorTheTable) {
  // More is seen of the floor than of the top of a block; too high for an object, the block is a table.
  for (const double height_m : {0.5, 0.3}) {
    const Box block{{0, 0, height_m / 2}, {0.3, 0.2, height_m / 2}, 0.2, {60, 90, 200}};
    const CastScene scene = make_scene({block}, testing::look_at_table(1.6, 0.9));
    const auto plane = fit(scene.pair);
    ASSERT_TRUE(plane);
    const double support_m = height_m > SegmentationOptions().max_height_m ? height_m : 0;
    EXPECT_NEAR(plane->height_m(scene.cam_from_table * Eigen::Vector3d(0, 0, support_m)), 0, 0.005);
    EXPECT_LT(angle_deg(plane->normal, scene.table.normal), 0.5);
  }
}

TEST(TablePlane, AWallIsNoTable) {
  const CastScene wall = make_scene({}, testing::look_at_table(0.7, 1.5707));
  EXPECT_FALSE(fit_table_plane(wall.pair, compute_disparity(wall.pair), testing::test_camera()));
}

TEST(TablePlane, GravityAllowsAnyPoseOfTheCamera) {
  // From right above, and upright no more: without gravity neither is taken for a table.
  for (const auto& pose :
       {testing::look_at_table(0.7, 90 * degree), testing::look_at_table(0.7, 0.7, 90 * degree),
        testing::look_at_table(0.7, 0.8, -80 * degree)}) {
    const CastScene scene = make_scene({tall_box, flat_box}, pose);
    EXPECT_FALSE(fit(scene.pair));
    SegmentationOptions options;
    // An inertial sensor measures in m/s², and is not mounted to a tenth of a degree.
    const Eigen::AngleAxisd error(3 * degree, Eigen::Vector3d(1, 2, -1).normalized());
    options.gravity = 9.81 * (error * -scene.table.normal);
    const auto plane = fit(scene.pair, options);
    ASSERT_TRUE(plane);
    EXPECT_LT(angle_deg(plane->normal, scene.table.normal), 0.15);
    EXPECT_NEAR(plane->height_m(scene.cam_from_table * Eigen::Vector3d(0, 0, 0)), 0, 0.001);

    const Disparity disparity = compute_disparity(scene.pair);
    const Segmentation found = segment_objects(scene.pair, disparity, testing::test_camera(), options);
    EXPECT_EQ(found.objects.size(), 2u);
  }
}

TEST(TablePlane, GravityTellsATableFromAWall) {
  const CastScene& scene = two_boxes();
  SegmentationOptions options;
  options.gravity = -scene.table.normal;
  EXPECT_TRUE(fit(scene.pair, options));
  options.gravity = Eigen::AngleAxisd(40 * degree, Eigen::Vector3d::UnitX()) * *options.gravity;
  EXPECT_FALSE(fit(scene.pair, options));
  options.gravity = scene.table.normal;  // things do not fall off ceilings
  EXPECT_FALSE(fit(scene.pair, options));
}

TEST(TablePlane, AKnownOneIsUsedAsItIs) {
  const CastScene& scene = two_boxes();
  SegmentationOptions options;
  options.table = scene.table;
  options.table->alpha = options.table->beta = options.table->delta_px = 77;  // not read
  const auto plane = fit(scene.pair, options);
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->offset_m, scene.table.offset_m);
  EXPECT_LT((plane->normal - scene.table.normal).norm(), 1e-12);
  EXPECT_NEAR(plane->alpha, scene.table.alpha, 1e-9);
  EXPECT_NEAR(plane->beta, scene.table.beta, 1e-9);
  EXPECT_NEAR(plane->delta_px, scene.table.delta_px, 1e-6);
  EXPECT_GT(plane->sigma_px, 0);

  const Segmentation found =
      segment_objects(scene.pair, compute_disparity(scene.pair), testing::test_camera(), options);
  ASSERT_TRUE(found.table);
  EXPECT_EQ(found.table->offset_m, scene.table.offset_m);
  EXPECT_EQ(found.objects.size(), 2u);
}

TEST(TablePlane, AKnownOneAndGravityMustMakeSense) {
  const auto rejected = [](const SegmentationOptions& options) {
    EXPECT_THROW(options.check(), InvalidInput);
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  TablePlane good;
  good.normal = Eigen::Vector3d(0, -0.6, -0.8);
  good.offset_m = 0.5;
  SegmentationOptions options;
  options.table = good;
  EXPECT_NO_THROW(options.check());
  for (const Eigen::Vector3d& normal :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, -6, -8), Eigen::Vector3d(nan, 0, 1)}) {
    options.table = good;
    options.table->normal = normal;
    rejected(options);
  }
  for (const double offset_m : {0.0, -0.5, nan, std::numeric_limits<double>::infinity()}) {
    options.table = good;
    options.table->offset_m = offset_m;
    rejected(options);
  }
  options.table.reset();
  for (const Eigen::Vector3d& gravity : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(nan, 0, 1),
                                         Eigen::Vector3d(0, std::numeric_limits<double>::infinity(), 0)}) {
    options.gravity = gravity;
    rejected(options);
  }
  options.gravity = Eigen::Vector3d(0, 9.81, 0);
  EXPECT_NO_THROW(options.check());
}

}  // namespace
}  // namespace graspctx
