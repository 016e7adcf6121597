// Tables without texture: what lies on them is told by colour.
#include <gtest/gtest.h>

#include <functional>

#include "graspctx/segmentation.hpp"
#include "overlap.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;
using testing::overlap;

const Box red_box{{-0.1, 0.03, 0.05}, {0.03, 0.02, 0.05}, 0.4, {60, 90, 200}};
const Box blue_box{{0.1, 0.02, 0.02}, {0.05, 0.035, 0.02}, -0.3, {190, 120, 60}};

/// Share of the light that reaches a point of the table.
using Light = std::function<double(double x_m, double y_m)>;

const Light all_light = [](double, double) { return 1.0; };

/// Hard shadows to the left of the boxes, and a lamp that reaches one side of the table better.
const Light shadows = [](double x, double y) {
  const bool dark =
      (x > -0.24 && x < -0.1 && y > 0 && y < 0.06) || (x > -0.02 && x < 0.1 && y > 0 && y < 0.04);
  return (dark ? 0.45 : 1) * (1 + 0.3 * x);
};

/// Takes the texture off the table.
void paint_table(cv::Mat& image, const cv::Mat& instance_ids, const Eigen::Isometry3d& cam_from_table,
                 const StereoCamera& camera, const Light& light) {
  const Eigen::Isometry3d table_from_cam = cam_from_table.inverse();
  const Eigen::Vector3d eye = table_from_cam.translation();
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      if (instance_ids.at<uchar>(v, u)) continue;
      const Eigen::Vector3d ray = table_from_cam.linear() * camera.ray({double(u), double(v)});
      const Eigen::Vector3d point = eye - eye.z() / ray.z() * ray;
      const double share = ray.z() < 0 ? light(point.x(), point.y()) : 1;
      image.at<cv::Vec3b>(v, u) = {cv::saturate_cast<uchar>(150 * share),
                                   cv::saturate_cast<uchar>(140 * share),
                                   cv::saturate_cast<uchar>(120 * share)};
    }
  }
}

CastScene plain_scene(const std::vector<Box>& boxes, const Light& light, double noise = 1) {
  const StereoCamera camera = testing::test_camera();
  const Eigen::Isometry3d left = testing::look_at_table();
  const Eigen::Isometry3d right = Eigen::Translation3d(-camera.baseline_m, 0, 0) * left;
  CastScene scene = testing::cast_scene(camera, boxes, left);
  const CastScene other = testing::cast_scene(camera, boxes, right);  // knows the right view's objects
  paint_table(scene.pair.left, scene.instance_ids, left, camera, light);
  paint_table(scene.pair.right, other.instance_ids, right, camera, light);
  testing::add_noise(scene.pair, noise);
  return scene;
}

Segmentation segment(const RectifiedPair& pair) {
  return segment_objects(pair, compute_disparity(pair), testing::test_camera());
}

TEST(PlainTable, ColourFindsEachObjectAndNoShadow) {
  const CastScene scene = plain_scene({red_box, blue_box}, shadows);
  const Segmentation found = segment(scene.pair);
  EXPECT_EQ(found.objects.size(), 2u);
  EXPECT_GT(overlap(scene, 1, found), 0.9);
  EXPECT_GT(overlap(scene, 2, found), 0.9);
}

TEST(PlainTable, AShadowAloneIsNoObject) {
  EXPECT_TRUE(segment(plain_scene({}, shadows).pair).objects.empty());
}

/// What a gain after the sensor's rounding makes of slow shading.
void round_to_steps(cv::Mat& image, double step) {
  cv::Mat values;
  image.convertTo(values, CV_32S, 1 / step);
  values.convertTo(image, CV_8U, step);
}

TEST(PlainTable, StepsInItsShadingAreNoObjects) {
  const Light lamp = [](double x, double y) { return 1 - 0.25 * (x * x + y * y); };
  for (const double step : {2.0, 2.5, 3.0}) {
    CastScene scene = plain_scene({red_box}, lamp, 0);
    round_to_steps(scene.pair.left, step);
    round_to_steps(scene.pair.right, step);
    testing::add_noise(scene.pair, 0.5);
    const Segmentation found = segment(scene.pair);
    EXPECT_EQ(found.objects.size(), 1u) << "steps of " << step;
    EXPECT_GT(overlap(scene, 1, found), 0.9) << "steps of " << step;
  }
}

TEST(PlainTable, BrightnessChangesNothing) {
  const CastScene scene = plain_scene({red_box, blue_box}, all_light);
  const Segmentation bright = segment(scene.pair);
  RectifiedPair dim;
  scene.pair.left.convertTo(dim.left, -1, 0.6);
  scene.pair.right.convertTo(dim.right, -1, 0.6);
  const Segmentation found = segment(dim);
  ASSERT_EQ(bright.objects.size(), 2u);
  ASSERT_EQ(found.objects.size(), 2u);
  const cv::Mat a = bright.instance_ids > 0, b = found.instance_ids > 0;
  EXPECT_GT(static_cast<double>(cv::countNonZero(a & b)) / cv::countNonZero(a | b), 0.95);
}

TEST(PlainTable, GreyImagesWork) {
  const CastScene scene = plain_scene({red_box, blue_box}, all_light);
  RectifiedPair grey;
  cv::extractChannel(scene.pair.left, grey.left, 2);
  cv::extractChannel(scene.pair.right, grey.right, 2);
  const Segmentation found = segment(grey);
  EXPECT_GT(overlap(scene, 1, found), 0.8);
  EXPECT_GT(overlap(scene, 2, found), 0.8);
}

}  // namespace
}  // namespace graspctx
