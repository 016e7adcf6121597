#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "graspctx/error.hpp"
#include "graspctx/segmentation.hpp"
#include "overlap.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;
using testing::overlap;

const Box tall_box{{-0.08, 0.03, 0.05}, {0.03, 0.02, 0.05}, 0.4, {60, 90, 200}};
const Box flat_box{{0.09, 0.02, 0.02}, {0.05, 0.035, 0.02}, -0.3, {190, 120, 60}};
const Box pencil{{0.0, -0.09, 0.0035}, {0.08, 0.0035, 0.0035}, 0.35, {50, 180, 190}};

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

Segmentation segment(const RectifiedPair& pair, const SegmentationOptions& options = {},
                     const StereoCamera& camera = testing::test_camera()) {
  return segment_objects(pair, compute_disparity(pair), camera, options);
}

Segmentation segment(const RectifiedPair& pair, CueLevel cues) {
  SegmentationOptions options;
  options.cues = cues;
  return segment(pair, options);
}

TEST(Segmentation, ColourFindsEachObjectAndNothingElse) {
  const CastScene scene = make_scene({tall_box, flat_box, pencil});
  const Segmentation found = segment(scene.pair);
  EXPECT_EQ(found.objects.size(), 3u);
  EXPECT_GT(overlap(scene, 1, found), 0.9);
  EXPECT_GT(overlap(scene, 2, found), 0.9);
  EXPECT_GT(overlap(scene, 3, found), 0.7);  // 7 mm high and as wide
  EXPECT_TRUE(found.table);
  EXPECT_TRUE(found.warnings.empty());
}

TEST(Segmentation, LevelsDifferAndRise) {
  const CastScene& scene = two_boxes();
  const Segmentation disparity = segment(scene.pair, CueLevel::disparity);
  const Segmentation plane = segment(scene.pair, CueLevel::plane);
  const Segmentation colour = segment(scene.pair, CueLevel::colour);
  EXPECT_FALSE(disparity.table);
  EXPECT_TRUE(plane.table);
  EXPECT_TRUE(colour.table);
  double mean[3] = {0, 0, 0};
  for (int id = 1; id <= 2; ++id) {
    mean[0] += overlap(scene, id, disparity) / 2;
    mean[1] += overlap(scene, id, plane) / 2;
    mean[2] += overlap(scene, id, colour) / 2;
  }
  EXPECT_GT(mean[0], 0.2);
  EXPECT_GT(mean[1], mean[0] + 0.02);
  EXPECT_GT(mean[2], mean[1] + 0.02);
}

TEST(Segmentation, DescribesItsObjects) {
  const Segmentation found = segment(two_boxes().pair);
  ASSERT_EQ(found.instance_ids.type(), CV_8UC1);
  ASSERT_EQ(found.instance_ids.size(), cv::Size(640, 480));
  cv::Mat rest = found.instance_ids.clone();
  double last = std::numeric_limits<double>::infinity();
  for (const ObjectHypothesis& object : found.objects) {
    const cv::Mat mask = found.instance_ids == object.id;
    EXPECT_EQ(object.bounding_box_px, cv::boundingRect(mask));
    const cv::Moments m = cv::moments(mask, true);
    EXPECT_NEAR(object.centroid_px.x(), m.m10 / m.m00, 1e-9);
    EXPECT_NEAR(object.centroid_px.y(), m.m01 / m.m00, 1e-9);
    EXPECT_FALSE(object.touches_border);
    EXPECT_LE(object.saliency, last);
    last = object.saliency;
    rest.setTo(0, mask);
  }
  EXPECT_EQ(cv::countNonZero(rest), 0);  // no id without its object
}

TEST(Segmentation, SaysHowFarEachObjectIs) {
  const CastScene& scene = two_boxes();
  const Segmentation found = segment(scene.pair);
  ASSERT_EQ(found.objects.size(), 2u);
  for (const ObjectHypothesis& object : found.objects) {
    std::vector<double> depths_m;
    for (int v = 0; v < found.instance_ids.rows; ++v) {
      for (int u = 0; u < found.instance_ids.cols; ++u) {
        if (found.instance_ids.at<uchar>(v, u) != object.id) continue;
        depths_m.push_back(testing::test_camera().depth_m(scene.disparity.at<float>(v, u)));
      }
    }
    std::nth_element(depths_m.begin(), depths_m.begin() + depths_m.size() / 2, depths_m.end());
    ASSERT_TRUE(object.depth_m);
    EXPECT_NEAR(*object.depth_m, depths_m[depths_m.size() / 2], 0.004);
  }
}

TEST(Segmentation, HeightsAreThoseOfTheSceneAndUnknownWithoutATable) {
  const CastScene& scene = two_boxes();
  const Segmentation found = segment(scene.pair);
  ASSERT_EQ(found.heights_m.type(), CV_32FC1);
  ASSERT_EQ(found.heights_m.size(), scene.pair.left.size());
  int known[3] = {0, 0, 0}, right[3] = {0, 0, 0};
  for (int v = 0; v < found.heights_m.rows; ++v) {
    for (int u = 0; u < found.heights_m.cols; ++u) {
      const float height_m = found.heights_m.at<float>(v, u), d = scene.disparity.at<float>(v, u);
      if (!std::isfinite(height_m) || !std::isfinite(d)) continue;
      const double truth_m = scene.table.height_m(testing::test_camera().triangulate({u, v}, d));
      const int on = scene.instance_ids.at<uchar>(v, u);
      ++known[on];
      right[on] += std::abs(height_m - truth_m) < 0.003 ? 1 : 0;
    }
  }
  for (const int on : {0, 1, 2}) {
    EXPECT_GT(known[on], 0.5 * cv::countNonZero(scene.instance_ids == on)) << on;
    EXPECT_GT(right[on], 0.9 * known[on]) << on;
  }
  EXPECT_TRUE(segment(scene.pair, CueLevel::disparity).heights_m.empty());
}

TEST(Segmentation, AnObjectCutByTheImageTouchesItsBorder) {
  const CastScene scene = make_scene({Box{{0.33, 0, 0.04}, {0.05, 0.04, 0.04}, 0.2, {60, 90, 200}}});
  const Segmentation found = segment(scene.pair);
  ASSERT_GT(overlap(scene, 1, found), 0.8);
  EXPECT_TRUE(found.objects.front().touches_border);
}

TEST(Segmentation, AnEmptyTableHoldsNothing) {
  const CastScene scene = make_scene({});
  for (const CueLevel cues : {CueLevel::plane, CueLevel::colour}) {
    EXPECT_TRUE(segment(scene.pair, cues).objects.empty());
  }
}

TEST(Segmentation, WhatIsNoStereoPairHoldsNothing) {
  const RectifiedPair& pair = two_boxes().pair;
  const CastScene elsewhere = make_scene({flat_box}, testing::look_at_table(0.6, 0.9, -0.1));
  cv::Mat upside_down;
  cv::flip(pair.right, upside_down, 0);
  const cv::Mat noise_a = testing::random_texture({640, 480}, 1, 1.5);
  const cv::Mat noise_b = testing::random_texture({640, 480}, 2, 1.5);
  const cv::Mat plain(480, 640, CV_8UC3, cv::Scalar(120, 130, 140));
  const std::vector<std::pair<std::string, RectifiedPair>> cases{
      {"swapped", {pair.right, pair.left}},
      {"identical", {pair.left, pair.left}},
      {"another scene", {pair.left, elsewhere.pair.right}},
      {"upside down", {pair.left, upside_down}},
      {"noise", {noise_a, noise_b}},
      {"plain", {plain, plain}}};
  for (const auto& [name, views] : cases) {
    for (const CueLevel cues : {CueLevel::disparity, CueLevel::plane, CueLevel::colour}) {
      const Segmentation found = segment(views, cues);
      EXPECT_TRUE(found.objects.empty()) << name;
      EXPECT_EQ(cv::countNonZero(found.instance_ids), 0) << name;
      EXPECT_FALSE(found.warnings.empty()) << name;
    }
  }
}

TEST(Segmentation, AFixationPicksTheObjectLookedAt) {
  const CastScene& scene = two_boxes();
  for (int id = 1; id <= 2; ++id) {
    const cv::Moments m = cv::moments(scene.instance_ids == id, true);
    SegmentationOptions options;
    options.fixation_px = Eigen::Vector2d(m.m10 / m.m00, m.m01 / m.m00);
    const Segmentation found = segment(scene.pair, options);
    ASSERT_EQ(found.objects.size(), 1u);
    EXPECT_GT(overlap(scene, id, found), 0.9);
  }
  SegmentationOptions options;
  options.fixation_px = Eigen::Vector2d(320, 440);  // bare table
  EXPECT_TRUE(segment(scene.pair, options).objects.empty());
  options.cues = CueLevel::disparity;
  options.max_extent_m = 1e9;  // reaches over every image
  EXPECT_NO_THROW(segment(scene.pair, options));
}

TEST(Segmentation, ABoxHoldsTheObjectAndCutsItOff) {
  const CastScene& scene = two_boxes();
  for (int id = 1; id <= 2; ++id) {
    const cv::Rect around = cv::boundingRect(scene.instance_ids == id);
    for (const CueLevel cues : {CueLevel::plane, CueLevel::colour}) {
      SegmentationOptions options;
      options.cues = cues;
      options.roi_px = around;
      const Segmentation found = segment(scene.pair, options);
      ASSERT_EQ(found.objects.size(), 1u);
      EXPECT_GT(overlap(scene, id, found), cues == CueLevel::colour ? 0.9 : 0.6);
      EXPECT_EQ(found.objects.front().bounding_box_px & around, found.objects.front().bounding_box_px);
    }
    SegmentationOptions options;
    options.roi_px = cv::Rect(around.x, around.y, around.width / 2, around.height);
    const Segmentation half = segment(scene.pair, options);
    ASSERT_EQ(half.objects.size(), 1u);
    EXPECT_EQ(half.objects.front().bounding_box_px & *options.roi_px, half.objects.front().bounding_box_px);
    EXPECT_GT(overlap(scene, id, half), 0.3);
  }
  SegmentationOptions options;
  options.roi_px = cv::Rect(260, 400, 120, 70);  // bare table
  for (const CueLevel cues : {CueLevel::plane, CueLevel::colour}) {
    options.cues = cues;
    EXPECT_TRUE(segment(scene.pair, options).objects.empty());
  }
  options.roi_px = cv::Rect(0, 0, 640, 480);  // all of it: one object, not the scene's
  EXPECT_EQ(segment(scene.pair, options).objects.size(), 1u);
  options.roi_px = cv::Rect(639, 479, 1, 1);
  EXPECT_TRUE(segment(scene.pair, options).objects.empty());
}

TEST(Segmentation, WithoutASupportPlaneItSaysSo) {
  // A box before a wall: the camera looks straight at it.
  const CastScene scene = make_scene({Box{{0, 0, 0.1}, {0.05, 0.04, 0.1}, 0.2, {60, 90, 200}}},
                                     testing::look_at_table(0.9, 1.5707));
  const Segmentation found = segment(scene.pair);
  EXPECT_FALSE(found.table);
  ASSERT_FALSE(found.warnings.empty());
  EXPECT_NE(found.warnings.front().find("no support plane"), std::string::npos);
  EXPECT_GT(overlap(scene, 1, found), 0.7);
}

TEST(Segmentation, MovesWithThePicture) {
  const CastScene& scene = two_boxes();
  constexpr int cut_px = 40;
  const cv::Rect kept(cut_px, 0, 640 - cut_px, 480);
  StereoCamera camera = testing::test_camera();
  camera.centre_px.x() -= cut_px;
  camera.width_px -= cut_px;
  const RectifiedPair cut{scene.pair.left(kept).clone(), scene.pair.right(kept).clone()};
  const Segmentation all = segment(scene.pair), moved = segment(cut, {}, camera);
  ASSERT_EQ(all.objects.size(), moved.objects.size());
  const cv::Mat a = all.instance_ids(kept) > 0, b = moved.instance_ids > 0;
  EXPECT_GT(static_cast<double>(cv::countNonZero(a & b)) / cv::countNonZero(a | b), 0.95);
}

TEST(Segmentation, LimitsOnSizeAndNumberAreKept) {
  const CastScene& scene = two_boxes();
  SegmentationOptions options;
  options.max_objects = 1;
  EXPECT_EQ(segment(scene.pair, options).objects.size(), 1u);
  options = {};
  options.max_height_m = 0.07;  // the tall box is 10 cm high
  const Segmentation low = segment(scene.pair, options);
  EXPECT_LT(overlap(scene, 1, low), 0.1);
  EXPECT_GT(overlap(scene, 2, low), 0.9);
  options = {};
  options.min_height_m = 0.06;  // the flat one is 4 cm
  const Segmentation high = segment(scene.pair, options);
  EXPECT_GT(overlap(scene, 1, high), 0.9);
  EXPECT_LT(overlap(scene, 2, high), 0.1);
}

TEST(Segmentation, GreyImagesWork) {
  const CastScene& scene = two_boxes();
  RectifiedPair grey;
  cv::cvtColor(scene.pair.left, grey.left, cv::COLOR_BGR2GRAY);
  cv::cvtColor(scene.pair.right, grey.right, cv::COLOR_BGR2GRAY);
  const Segmentation found = segment(grey);
  EXPECT_GT(overlap(scene, 1, found), 0.85);
  EXPECT_GT(overlap(scene, 2, found), 0.85);
}

TEST(Segmentation, TheSameBytesForAnyNumberOfThreadsAndAnyRun) {
  const RectifiedPair& pair = two_boxes().pair;
  const int before = cv::getNumThreads();
  for (const CueLevel cues : {CueLevel::disparity, CueLevel::plane, CueLevel::colour}) {
    cv::setNumThreads(1);
    const Segmentation one = segment(pair, cues);
    for (const int threads : {1, 2, 5}) {
      cv::setNumThreads(threads);
      cv::theRNG().state = 12345u + static_cast<unsigned>(threads);
      const Segmentation again = segment(pair, cues);
      EXPECT_EQ(cv::countNonZero(one.instance_ids != again.instance_ids), 0);
      ASSERT_EQ(one.objects.size(), again.objects.size());
      if (one.table) {
        EXPECT_EQ(one.table->normal, again.table->normal);
        EXPECT_EQ(one.table->offset_m, again.table->offset_m);
      }
    }
  }
  cv::setNumThreads(before);
}

TEST(Segmentation, FromAMask) {
  cv::Mat mask = cv::Mat::zeros(100, 120, CV_8UC1);
  mask(cv::Rect(10, 20, 30, 5)).setTo(7);
  mask(cv::Rect(0, 50, 40, 40)).setTo(200);
  const Segmentation found = segmentation_from_mask(mask, {120, 100});
  ASSERT_EQ(found.objects.size(), 2u);
  EXPECT_EQ(found.objects[0].id, 200);
  EXPECT_TRUE(found.objects[0].touches_border);
  EXPECT_EQ(found.objects[1].id, 7);
  EXPECT_EQ(found.objects[1].bounding_box_px, cv::Rect(10, 20, 30, 5));
  EXPECT_NEAR(found.objects[1].centroid_px.x(), 24.5, 1e-9);
  EXPECT_NEAR(found.objects[1].centroid_px.y(), 22, 1e-9);
  EXPECT_FALSE(found.objects[1].touches_border);
  EXPECT_FALSE(found.objects[1].depth_m);
  EXPECT_TRUE(found.heights_m.empty());
  EXPECT_EQ(cv::countNonZero(found.instance_ids != mask), 0);
  mask.setTo(0);
  EXPECT_EQ(cv::countNonZero(found.instance_ids), 30 * 5 + 40 * 40);  // it is its own copy
  EXPECT_TRUE(segmentation_from_mask(mask, {120, 100}).objects.empty());
  EXPECT_THROW(segmentation_from_mask(mask, {100, 120}), InvalidInput);
  EXPECT_THROW(segmentation_from_mask(cv::Mat::zeros(100, 120, CV_8UC3), {120, 100}), InvalidInput);
  EXPECT_THROW(segmentation_from_mask({}, {120, 100}), InvalidInput);
}

TEST(Segmentation, BadInputIsNamed) {
  const RectifiedPair& pair = two_boxes().pair;
  const Disparity disparity = compute_disparity(pair);
  const StereoCamera camera = testing::test_camera();
  EXPECT_THROW(segment_objects({pair.left, {}}, disparity, camera), InvalidInput);
  EXPECT_THROW(segment_objects({pair.left, pair.right(cv::Rect(0, 0, 600, 480))}, disparity, camera),
               InvalidInput);
  EXPECT_THROW(segment_objects(pair, {disparity.dense, {}}, camera), InvalidInput);
  EXPECT_THROW(segment_objects(pair, {disparity.dense(cv::Rect(0, 0, 10, 10)), disparity.reliable}, camera),
               InvalidInput);
  EXPECT_THROW(segment_objects(pair, disparity, StereoCamera{}), InvalidInput);
  EXPECT_THROW(fit_table_plane(pair, {}, camera), InvalidInput);
  const auto refused = [&](const std::string& name, const auto& change) {
    SegmentationOptions options;
    change(options);
    try {
      segment_objects(pair, disparity, camera, options);
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      return;
    }
    ADD_FAILURE() << name << " was accepted";
  };
  refused("max_objects", [](auto& o) { o.max_objects = 0; });
  refused("max_objects", [](auto& o) { o.max_objects = 256; });
  refused("min_height_m", [](auto& o) { o.min_height_m = 0.5; });
  refused("min_extent_m", [](auto& o) { o.min_extent_m = -1; });
  refused("max_extent_m", [](auto& o) { o.max_extent_m = std::nan(""); });
  refused("min_reliable_share", [](auto& o) { o.min_reliable_share = 2; });
  refused("cell_m", [](auto& o) { o.cell_m = 0; });
  refused("cues", [](auto& o) { o.cues = static_cast<CueLevel>(7); });
  refused("fixation_px", [](auto& o) { o.fixation_px = Eigen::Vector2d(640, 10); });
  refused("fixation_px", [](auto& o) { o.fixation_px = Eigen::Vector2d(std::nan(""), 10); });
  constexpr int most = std::numeric_limits<int>::max();
  for (const cv::Rect& box : {cv::Rect(0, 0, 0, 10), cv::Rect(-1, 0, 10, 10), cv::Rect(600, 0, 41, 10),
                              cv::Rect(0, 470, 10, 11), cv::Rect(most, most, most, most)}) {
    refused("roi_px", [&](auto& o) { o.roi_px = box; });
  }
  refused("fixation_px must lie inside roi_px", [](auto& o) {
    o.roi_px = cv::Rect(10, 10, 20, 20);
    o.fixation_px = Eigen::Vector2d(30, 15);
  });
}

}  // namespace
}  // namespace graspctx
