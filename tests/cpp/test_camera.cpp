#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "graspctx/camera.hpp"
#include "graspctx/error.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

TEST(Camera, TriangulatesWhatItProjects) {
  StereoCamera camera = testing::test_camera();
  camera.doffs_px = 12.5;
  std::mt19937 generator(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d point_m(testing::uniform(generator, -0.5, 0.5),
                                  testing::uniform(generator, -0.5, 0.5),
                                  testing::uniform(generator, 0.3, 3));
    const Eigen::Vector2d left_px = camera.project(point_m);
    // The right camera stands baseline_m to the right, its principal point doffs_px further right in its
    // image.
    const double right_u = camera.focal_px * (point_m.x() - camera.baseline_m) / point_m.z() +
                           camera.centre_px.x() + camera.doffs_px;
    const Eigen::Vector3d found_m = camera.triangulate(left_px, left_px.x() - right_u);
    EXPECT_LT((found_m - point_m).norm(), 1e-9);
    EXPECT_NEAR(camera.disparity_px(point_m.z()), left_px.x() - right_u, 1e-9);
    EXPECT_LT((camera.ray(left_px) - point_m.normalized()).norm(), 1e-12);
  }
}

TEST(Camera, IsInfinitelyFarWithoutDisparity) {
  const StereoCamera camera = testing::test_camera();
  EXPECT_TRUE(std::isinf(camera.depth_m(0)));
  EXPECT_TRUE(std::isinf(camera.depth_m(-3)));
}

TEST(Camera, RefusesImpossibleCalibrations) {
  const auto broken = [](auto&& change) {
    StereoCamera camera = testing::test_camera();
    change(camera);
    return camera;
  };
  EXPECT_NO_THROW(testing::test_camera().check());
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(broken([](StereoCamera& c) { c.focal_px = 0; }).check(), InvalidInput);
  EXPECT_THROW(broken([](StereoCamera& c) { c.focal_px = nan; }).check(), InvalidInput);
  EXPECT_THROW(broken([](StereoCamera& c) { c.baseline_m = -0.1; }).check(), InvalidInput);
  EXPECT_THROW(broken([](StereoCamera& c) { c.centre_px.x() = nan; }).check(), InvalidInput);
  EXPECT_THROW(broken([](StereoCamera& c) { c.doffs_px = 1 / 0.0; }).check(), InvalidInput);
  EXPECT_THROW(broken([](StereoCamera& c) { c.width_px = -1; }).check(), InvalidInput);
  const auto raw = [](auto&& change) {
    StereoCamera camera = testing::test_camera();
    RawView view;
    view.camera_matrix << 500, 0, 320, 0, 500, 240, 0, 0, 1;
    camera.raw = {view, view};
    change((*camera.raw)[1]);
    return camera;
  };
  EXPECT_NO_THROW(raw([](RawView&) {}).check());
  EXPECT_THROW(raw([](RawView& v) { v.distortion = {1, 2, 3}; }).check(), InvalidInput);
  EXPECT_THROW(raw([](RawView& v) { v.distortion = {0, 0, 0, 0, nan}; }).check(), InvalidInput);
  EXPECT_THROW(raw([](RawView& v) { v.rectified_from_raw *= 2; }).check(), InvalidInput);
  EXPECT_THROW(raw([](RawView& v) { v.rectified_from_raw.row(0) *= -1; }).check(), InvalidInput);
}

}  // namespace
}  // namespace graspctx
