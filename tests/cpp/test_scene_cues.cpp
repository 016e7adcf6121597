#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "detail/scene_cues.hpp"
#include "detail/table_view.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using detail::SceneCues;
using detail::TableView;

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

std::vector<std::pair<std::string, cv::Mat>> maps(const SceneCues& cues) {
  return {{"image", cues.image},
          {"lab", cues.lab},
          {"residual_px", cues.residual_px},
          {"sigma_px", cues.sigma_px},
          {"dense_px", cues.dense_px},
          {"height_m", cues.height_m},
          {"dense_height_m", cues.dense_height_m},
          {"disparity_px", cues.disparity_px},
          {"point_m", cues.point_m},
          {"table_misfit", cues.table_misfit},
          {"inside_table_m", cues.inside_table_m},
          {"table_likeness", cues.table_likeness},
          {"plain_sigmas", cues.plain_sigmas},
          {"plain_light", cues.plain_light},
          {"plain_off_hue", cues.plain_off_hue},
          {"on_plain_table", cues.on_plain_table},
          {"first_guess", cues.first_guess},
          {"guess_piece", cues.guess_piece},
          {"raised_piece", cues.raised_piece}};
}

void expect_maps(const SceneCues& cues, const cv::Size& size) {
  for (const auto& [name, map] : maps(cues)) {
    EXPECT_EQ(map.size(), size) << name;
    const int type = name == "image"                                     ? CV_8UC3
                     : name == "lab" || name == "point_m"                ? CV_32FC3
                     : name == "on_plain_table" || name == "first_guess" ? CV_8UC1
                     : name == "guess_piece" || name == "raised_piece"   ? CV_32SC1
                                                                         : CV_32FC1;
    EXPECT_EQ(map.type(), type) << name;
  }
}

/// Disparities that rise by a plane, without a right view that shows them.
struct Slanted {
  RectifiedPair pair;
  Disparity disparity;
  StereoCamera camera = testing::test_camera();
  explicit Slanted(const cv::Size& size) {
    pair.left = testing::random_texture(size, 4);
    pair.right = pair.left.clone();
    disparity.dense = cv::Mat(size, CV_32FC1);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        disparity.dense.at<float>(v, u) = static_cast<float>(40 + 0.01 * u + 0.05 * v);
      }
    }
    disparity.reliable = disparity.dense;
    camera.width_px = size.width;
    camera.height_px = size.height;
    camera.centre_px = {size.width / 2.0, size.height / 2.0};
  }
};

TEST(SceneCues, WithoutAPlaneNothingIsKnownOverIt) {
  const Slanted scene({320, 240});
  const SceneCues cues = detail::scene_cues(scene.pair, scene.disparity, scene.camera, TableView{});
  expect_maps(cues, {320, 240});
  EXPECT_FALSE(cues.has_plane);
  EXPECT_FALSE(cues.has_plain_table);
  for (const cv::Mat& map : {cues.residual_px, cues.dense_px, cues.height_m, cues.dense_height_m}) {
    EXPECT_EQ(cv::countNonZero(map == map), 0);  // only what is no number differs from itself
  }
  EXPECT_EQ(cv::countNonZero(cues.table_misfit != -1), 0);
  EXPECT_EQ(cv::countNonZero(cues.plain_sigmas), 0);
  EXPECT_EQ(cv::countNonZero(cues.on_plain_table), 0);
  EXPECT_EQ(cv::countNonZero(cues.first_guess), 0);
  EXPECT_LT(cv::norm(cues.table_likeness, cv::NORM_INF), 1e-6);  // no ground: no colour is likelier
  EXPECT_EQ(cv::norm(cues.disparity_px, scene.disparity.dense, cv::NORM_INF), 0);
}

TEST(SceneCues, PointsAreThoseTheCameraTriangulates) {
  Slanted scene({320, 240});
  scene.camera.doffs_px = 3;
  scene.disparity.dense.at<float>(20, 30) = unknown;
  scene.disparity.dense.at<float>(20, 31) = -2.5F;  // half a pixel with doffs: too far away
  scene.disparity.dense.at<float>(20, 32) = -1.5F;  // near enough
  const SceneCues cues = detail::scene_cues(scene.pair, scene.disparity, scene.camera, TableView{});
  for (const cv::Point& at : {cv::Point(0, 0), cv::Point(319, 239), cv::Point(50, 200), cv::Point(250, 17)}) {
    const Eigen::Vector3d truth =
        scene.camera.triangulate({at.x, at.y}, double(scene.disparity.dense.at<float>(at)));
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(cues.point_m.at<cv::Vec3f>(at)[axis], truth[axis], 1e-6);
  }
  EXPECT_TRUE(std::isnan(cues.point_m.at<cv::Vec3f>(20, 30)[2]));
  EXPECT_TRUE(std::isnan(cues.point_m.at<cv::Vec3f>(20, 31)[2]));
  EXPECT_FALSE(std::isnan(cues.point_m.at<cv::Vec3f>(20, 32)[2]));
}

TEST(SceneCues, OfALargeImageAreSmallerAndSayTheSame) {
  const Slanted scene({1600, 1200});
  const SceneCues cues = detail::scene_cues(scene.pair, scene.disparity, scene.camera, TableView{});
  expect_maps(cues, {640, 480});
  for (const cv::Point& at : {cv::Point(0, 0), cv::Point(639, 479), cv::Point(100, 300)}) {
    // Disparities and points stay those of the full-size image.
    const cv::Vec3f p = cues.point_m.at<cv::Vec3f>(at);
    const Eigen::Vector2d seen = scene.camera.project({p[0], p[1], p[2]});
    EXPECT_NEAR(seen.x(), 2.5 * at.x + 0.75, 1.3);
    EXPECT_NEAR(seen.y(), 2.5 * at.y + 0.75, 1.3);
    EXPECT_NEAR(cues.disparity_px.at<float>(at), 40 + 0.01 * seen.x() + 0.05 * seen.y(), 1e-3);
  }
  cv::Mat small;
  cv::resize(scene.pair.left, small, {640, 480}, 0, 0, cv::INTER_AREA);
  EXPECT_LE(cv::norm(small, cues.image, cv::NORM_INF), 1);
}

TEST(SceneCues, OfAnImageThatIsHardlyTooLargeKeepItsSize) {
  const Slanted scene({800, 100});
  expect_maps(detail::scene_cues(scene.pair, scene.disparity, scene.camera, TableView{}), {800, 100});
}

TEST(SceneCues, GreyViewsHaveColourlessCues) {
  Slanted scene({320, 240});
  scene.pair.left = cv::Mat(240, 320, CV_8UC1, cv::Scalar(119));
  scene.pair.right = scene.pair.left;
  const SceneCues cues = detail::scene_cues(scene.pair, scene.disparity, scene.camera, TableView{});
  expect_maps(cues, {320, 240});
  EXPECT_EQ(cues.image.at<cv::Vec3b>(100, 100), cv::Vec3b(119, 119, 119));
  const cv::Vec3f lab = cues.lab.at<cv::Vec3f>(100, 100);
  EXPECT_NEAR(lab[0], 0.5 * 255, 2);  // CIE lightness 50
  EXPECT_NEAR(lab[1], 128, 1);
  EXPECT_NEAR(lab[2], 128, 1);
}

TEST(SceneCues, TellABoxFromTheTableItStandsOn) {
  const testing::Box box{{0, 0, 0.03}, {0.05, 0.04, 0.03}, 0.3, {60, 90, 200}};
  const StereoCamera camera = testing::test_camera();
  testing::CastScene scene = testing::cast_scene(camera, {box});
  testing::add_noise(scene.pair, 1);
  const Disparity disparity = compute_disparity(scene.pair);
  const TableView view = detail::look_at_table(scene.pair, disparity, camera, SegmentationOptions{});
  ASSERT_TRUE(view.plane);
  const SceneCues cues = detail::scene_cues(scene.pair, disparity, camera, view);
  expect_maps(cues, {640, 480});
  EXPECT_TRUE(cues.has_plane);
  // The middle of its top, and table beside it.
  const Eigen::Vector2d seen = camera.project(scene.cam_from_table * Eigen::Vector3d(0, 0, 0.06));
  const cv::Point top(static_cast<int>(std::lround(seen.x())), static_cast<int>(std::lround(seen.y())));
  const cv::Rect on_top(top.x - 15, top.y - 8, 30, 16), on_table(100, 300, 80, 80);
  ASSERT_EQ(cv::countNonZero(scene.instance_ids(on_top) != 1), 0);
  ASSERT_EQ(cv::countNonZero(scene.instance_ids(on_table)), 0);
  const auto mean = [](const cv::Mat& map, const cv::Rect& in) {
    const cv::Mat part = map(in);
    return cv::mean(part, part == part)[0];
  };
  EXPECT_NEAR(mean(cues.height_m, on_top), 0.06, 0.002);
  EXPECT_NEAR(mean(cues.height_m, on_table), 0, 0.002);
  EXPECT_NEAR(mean(cues.dense_height_m, on_top), 0.06, 0.004);
  EXPECT_NEAR(mean(cues.dense_height_m, on_table), 0, 0.004);
  EXPECT_GT(mean(cues.residual_px, on_top), 2);
  EXPECT_NEAR(mean(cues.residual_px, on_table), 0, 0.1);
  EXPECT_NEAR(mean(cues.disparity_px, on_top), mean(scene.disparity, on_top), 0.2);
  EXPECT_GT(mean(cues.table_misfit, on_top), 2 * mean(cues.table_misfit, on_table) + 1);
  EXPECT_GT(mean(cues.table_likeness, on_table), mean(cues.table_likeness, on_top) + 1);
  EXPECT_GT(mean(cues.inside_table_m, on_table), 0.02);
}

TEST(SceneCues, TellAnObjectFromAPlainTableByItsColour) {
  Slanted scene({320, 240});
  scene.pair.left = cv::Mat(240, 320, CV_8UC3, cv::Scalar(190, 200, 205));
  const cv::Rect object(140, 100, 50, 40), table(20, 150, 80, 60);
  scene.pair.left(object).setTo(cv::Scalar(40, 60, 160));
  scene.pair.right = scene.pair.left.clone();
  testing::add_noise(scene.pair, 1);
  TableView view;
  view.plain = detail::find_plain_table(scene.pair.left);
  ASSERT_TRUE(view.plain);
  const SceneCues cues = detail::scene_cues(scene.pair, scene.disparity, scene.camera, view);
  expect_maps(cues, {320, 240});
  EXPECT_TRUE(cues.has_plain_table);
  EXPECT_FALSE(cues.has_plane);
  EXPECT_GT(cv::mean(cues.plain_sigmas(object))[0], 10);
  EXPECT_LT(cv::mean(cues.plain_sigmas(table))[0], 3);
  EXPECT_NEAR(cv::mean(cues.plain_light(table))[0], 1, 0.05);
  EXPECT_EQ(cv::countNonZero(cues.on_plain_table(object)), object.area());
  EXPECT_GT(cv::mean(cues.table_likeness(table))[0], cv::mean(cues.table_likeness(object))[0] + 3);
}

}  // namespace
}  // namespace graspctx
