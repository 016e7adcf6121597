#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "graspctx/error.hpp"
#include "graspctx/io/picture.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;
using testing::test_camera;

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
const cv::Size image_px(640, 480);

/// All that is true of a scene, as a perfect segmentation would have it.
struct KnownScene {
  CastScene cast;
  Disparity disparity;
  std::map<CueLevel, Segmentation> levels;
};

const KnownScene& known_scene() {
  static const KnownScene scene = [] {
    KnownScene known;
    known.cast = testing::cast_scene(test_camera(),
                                     {Box{{-0.08, 0.03, 0.05}, {0.03, 0.02, 0.05}, 0.4, {60, 90, 200}},
                                      Box{{0.09, 0.02, 0.02}, {0.05, 0.035, 0.02}, -0.3, {190, 120, 60}}});
    known.disparity = {known.cast.disparity.clone(), known.cast.disparity.clone()};
    Segmentation segmentation = segmentation_from_mask(known.cast.instance_ids, image_px);
    known.levels[CueLevel::disparity] = segmentation;
    segmentation.table = known.cast.table;
    segmentation.heights_m = cv::Mat(image_px, CV_32FC1, cv::Scalar(unknown));
    for (int v = 0; v < image_px.height; ++v) {
      for (int u = 0; u < image_px.width; ++u) {
        const Eigen::Vector3d point_m =
            test_camera().triangulate({u, v}, known.cast.disparity.at<float>(v, u));
        segmentation.heights_m.at<float>(v, u) = static_cast<float>(known.cast.table.height_m(point_m));
      }
    }
    known.levels[CueLevel::plane] = known.levels[CueLevel::colour] = segmentation;
    return known;
  }();
  return scene;
}

cv::Mat draw(const KnownScene& scene, const SegmentationOptions& options = {}, int panel_px = 640) {
  return draw_segmentation(scene.cast.pair.left, scene.disparity, test_camera(), scene.levels, options,
                           panel_px);
}

KnownScene without_objects() {
  KnownScene scene = known_scene();
  for (auto& [level, segmentation] : scene.levels) {
    segmentation.objects.clear();
    segmentation.instance_ids = cv::Mat::zeros(image_px, CV_8UC1);
  }
  return scene;
}

enum Panel { hypotheses, disparity, table, heights, level_disparity, level_plane, level_colour };

/// A panel of a sheet that was drawn with as many pixels as the image has. The first one of a scene without
/// objects is the image itself: that says where the panels lie.
cv::Mat panel(const cv::Mat& sheet, Panel which) {
  static const cv::Rect first = [] {
    const cv::Mat empty = draw(without_objects());
    const int gap = (empty.cols - 4 * image_px.width) / 5;
    for (int y = 0; y + image_px.height <= empty.rows; ++y) {
      const cv::Rect at({gap, y}, image_px);
      if (cv::norm(empty(at), known_scene().cast.pair.left, cv::NORM_INF) == 0) return at;
    }
    throw std::runtime_error("the image is in no panel");
  }();
  const int row_px = (sheet.rows - first.x) / 2, column_px = (sheet.cols - first.x) / 4;
  return sheet(first + cv::Point(which % 4 * column_px, which / 4 * row_px));
}

double brightness(const cv::Mat& picture, const cv::Mat& where) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return cv::mean(grey, where)[0];
}

cv::Mat coloured(const cv::Mat& picture) {
  std::vector<cv::Mat> channels;
  cv::split(picture, channels);
  cv::Mat least, most;
  cv::min(channels[0], cv::min(channels[1], channels[2]), least);
  cv::max(channels[0], cv::max(channels[1], channels[2]), most);
  return most - least > 12;
}

TEST(SegmentationPicture, TheGridLiesOnTheTable) {
  const KnownScene& scene = known_scene();
  // The camera looks along the table frame's y, so that the grid's lines run along its x and y.
  const cv::Mat grid = coloured(panel(draw(scene), table));
  const Eigen::Isometry3d table_from_cam = scene.cast.cam_from_table.inverse();
  // Where the lines lie is known but for one offset along each axis: the first that is found.
  int lines = 0, off_lines = 0, on_objects = 0;
  const Eigen::Vector3d eye = table_from_cam.translation();
  const Eigen::Vector3d ahead_3d = table_from_cam.linear() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector2d ahead = ahead_3d.head<2>().normalized(), right(ahead.y(), -ahead.x());
  for (int v = 0; v < grid.rows; ++v) {
    for (int u = 0; u < grid.cols; ++u) {
      if (!grid.at<uchar>(v, u)) continue;
      ++lines;
      on_objects += scene.cast.instance_ids.at<uchar>(v, u) > 0 ? 1 : 0;
      const Eigen::Vector3d ray = table_from_cam.linear() * test_camera().ray({u, v});
      const Eigen::Vector2d at =
          (eye - eye.z() / ray.z() * ray - Eigen::Vector3d(eye.x(), eye.y(), 0)).head<2>();
      const double pixel_m = -eye.z() / ray.z() / test_camera().focal_px / -ray.normalized().z();
      double nearest_m = 1;
      for (const double along : {at.dot(ahead), at.dot(right)}) {
        nearest_m = std::min(nearest_m, std::abs(along - 0.05 * std::round(along / 0.05)));
      }
      off_lines += nearest_m > 1.5 * pixel_m ? 1 : 0;
    }
  }
  EXPECT_GT(lines, 5000);
  EXPECT_LT(off_lines, 0.01 * lines);
  EXPECT_LT(on_objects, 0.01 * lines);  // what stands on the table hides it
}

TEST(SegmentationPicture, WhatIsHigherIsBrighter) {
  const KnownScene& scene = known_scene();
  const cv::Mat& heights_m = scene.levels.at(CueLevel::colour).heights_m;
  const cv::Mat picture = panel(draw(scene), heights);
  double last = 0;
  for (const double height_m : {0.0, 0.02, 0.05, 0.09}) {
    cv::Mat where;
    cv::inRange(heights_m, height_m - 0.004, height_m + 0.004, where);
    ASSERT_GT(cv::countNonZero(where), 100);
    EXPECT_GT(brightness(picture, where), last + 5) << height_m;
    last = brightness(picture, where);
  }
}

TEST(SegmentationPicture, NearIsBrightAndUnknownHasNoColour) {
  KnownScene scene = known_scene();
  const cv::Rect hole(200, 100, 60, 50), guess(300, 350, 60, 50);
  scene.disparity = {scene.disparity.dense.clone(), scene.disparity.reliable.clone()};
  scene.disparity.dense(hole).setTo(unknown);
  scene.disparity.reliable(hole).setTo(unknown);
  scene.disparity.reliable(guess).setTo(unknown);
  const cv::Mat sure = panel(draw(known_scene()), disparity), picture = panel(draw(scene), disparity);
  EXPECT_EQ(cv::countNonZero(coloured(picture(hole))), 0);
  EXPECT_GT(cv::countNonZero(coloured(picture(guess))), 0.9 * guess.area());
  EXPECT_LT(brightness(picture(guess), {}), 0.6 * brightness(sure(guess), {}));
  EXPECT_GT(brightness(sure.row(470), {}), brightness(sure.row(40), {}) + 50);
}

TEST(SegmentationPicture, AnObjectHasItsColourAtEveryLevel) {
  KnownScene scene = known_scene();
  Segmentation& plane = scene.levels.at(CueLevel::plane);
  // The other way round there, with other ids.
  std::swap(plane.objects[0], plane.objects[1]);
  const cv::Mat ids = plane.instance_ids;
  plane.instance_ids = ids.clone();
  plane.instance_ids.setTo(2, ids == 1);
  plane.instance_ids.setTo(1, ids == 2);
  for (ObjectHypothesis& object : plane.objects) object.id = 3 - object.id;
  const cv::Mat sheet = draw(scene);
  std::vector<cv::Scalar> tints;
  for (const int id : {1, 2}) {
    cv::Mat inside;
    cv::erode(scene.cast.instance_ids == id, inside, cv::Mat::ones(9, 9, CV_8UC1));
    const cv::Scalar colour = cv::mean(panel(sheet, level_colour), inside);
    EXPECT_LT(cv::norm(colour - cv::mean(panel(sheet, level_plane), inside)), 3) << id;
    const cv::Scalar own = cv::mean(scene.cast.pair.left, inside);
    EXPECT_GT(cv::norm(colour - own), 10) << id;
    tints.push_back(colour - 0.65 * own);
  }
  EXPECT_GT(cv::norm(tints[0] - tints[1]), 20);
}

TEST(SegmentationPicture, MarksTheSideThatCutsAnObject) {
  const KnownScene& scene = known_scene();
  KnownScene cut = scene;
  cv::Mat ids = cv::Mat::zeros(image_px, CV_8UC1);
  ids(cv::Rect(590, 200, 50, 80)).setTo(1);
  for (auto& [level, segmentation] : cut.levels) {
    Segmentation other = segmentation_from_mask(ids, image_px);
    ASSERT_TRUE(other.objects[0].touches_border);
    segmentation.instance_ids = other.instance_ids;
    segmentation.objects = other.objects;
  }
  const cv::Mat marked = panel(draw(cut), hypotheses);
  for (auto& [level, segmentation] : cut.levels) segmentation.objects[0].touches_border = false;
  const cv::Mat plain = panel(draw(cut), hypotheses);
  EXPECT_GT(cv::norm(marked(cv::Rect(637, 203, 3, 74)), plain(cv::Rect(637, 203, 3, 74)), cv::NORM_L1) / 222,
            50);
  EXPECT_EQ(cv::norm(marked.colRange(0, 300), plain.colRange(0, 300), cv::NORM_INF), 0);
}

TEST(SegmentationPicture, ShowsWhereTheCallerLooks) {
  SegmentationOptions options;
  options.roi_px = cv::Rect(100, 60, 200, 150);
  options.fixation_px = Eigen::Vector2d(200, 100);
  cv::Mat changed;
  cv::absdiff(panel(draw(without_objects(), options), hypotheses), known_scene().cast.pair.left, changed);
  cv::cvtColor(changed, changed, cv::COLOR_BGR2GRAY);
  changed = changed > 0;
  const cv::Rect seen = cv::boundingRect(changed);
  EXPECT_NEAR(seen.x, 100, 3);
  EXPECT_NEAR(seen.y, 60, 3);
  EXPECT_NEAR(seen.br().x, 300, 3);
  EXPECT_NEAR(seen.br().y, 210, 3);
  EXPECT_TRUE(changed.at<uchar>(100, 200));
  EXPECT_FALSE(changed.at<uchar>(160, 250));
}

TEST(SegmentationPicture, HasTheAskedSizeForAnyImage) {
  for (const int panel_px : {160, 320, 1000}) {
    const cv::Mat sheet = draw(known_scene(), {}, panel_px);
    EXPECT_EQ(sheet.type(), CV_8UC3);
    EXPECT_NEAR(sheet.cols, 4.1 * panel_px, 0.1 * panel_px);
  }
  for (const cv::Size& size :
       {cv::Size(1, 1), cv::Size(3000, 16), cv::Size(16, 3000), cv::Size(1500, 2000)}) {
    const cv::Mat image(size, CV_8UC1, cv::Scalar(100));  // grey
    const cv::Mat nothing(size, CV_32FC1, cv::Scalar(unknown));
    cv::Mat ids(size, CV_8UC1, cv::Scalar(7));
    StereoCamera camera = test_camera();
    const cv::Mat sheet = draw_segmentation(image, {nothing, nothing}, camera,
                                            {{CueLevel::colour, segmentation_from_mask(ids, size)}});
    EXPECT_LT(sheet.cols, 2800);
    EXPECT_LT(sheet.rows, 1600);
  }
}

TEST(SegmentationPicture, ATableWithoutAnythingKnownAndCamerasThatLookAnywhere) {
  for (const Eigen::Vector3d& normal : {Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(1, 0, 0),
                                        Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 0.6, 0.8)}) {
    KnownScene scene = known_scene();
    for (const CueLevel level : {CueLevel::plane, CueLevel::colour}) {
      scene.levels[level].table->normal = normal;
      scene.levels[level].heights_m = cv::Mat(image_px, CV_32FC1, cv::Scalar(unknown));
    }
    EXPECT_FALSE(draw(scene).empty());
  }
}

TEST(SegmentationPicture, TheSameBytesAndNothingElseChanged) {
  const KnownScene scene = known_scene();
  const cv::Mat ids = scene.levels.at(CueLevel::colour).instance_ids.clone(),
                left = scene.cast.pair.left.clone();
  EXPECT_EQ(cv::norm(draw(scene), draw(scene), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(ids, scene.levels.at(CueLevel::colour).instance_ids, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(left, scene.cast.pair.left, cv::NORM_INF), 0);
}

TEST(SegmentationPicture, RefusesWhatDoesNotFit) {
  const auto refuses = [](const auto& change) {
    KnownScene scene = known_scene();
    SegmentationOptions options;
    int panel_px = 640;
    change(scene, options, panel_px);
    EXPECT_THROW(draw(scene, options, panel_px), InvalidInput);
  };
  refuses([](KnownScene& scene, auto&, int&) { scene.levels.erase(CueLevel::colour); });
  refuses([](KnownScene& scene, auto&, int&) { scene.cast.pair.left = cv::Mat(); });
  refuses([](KnownScene& scene, auto&, int&) { scene.disparity.reliable = cv::Mat(); });
  refuses([](KnownScene& scene, auto&, int&) { scene.disparity.dense = cv::Mat::zeros(9, 9, CV_32FC1); });
  refuses([](KnownScene& scene, auto&, int&) {
    scene.levels[CueLevel::plane].instance_ids = cv::Mat::zeros(9, 9, CV_8UC1);
  });
  refuses([](KnownScene& scene, auto&, int&) {
    scene.levels[CueLevel::plane].heights_m = cv::Mat::zeros(9, 9, CV_32FC1);
  });
  refuses([](KnownScene&, auto&, int& panel_px) { panel_px = 159; });
  refuses([](KnownScene&, auto&, int& panel_px) { panel_px = 4097; });
  refuses([](KnownScene&, SegmentationOptions& options, int&) { options.max_objects = 0; });
}

}  // namespace
}  // namespace graspctx
