#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "graspctx/error.hpp"
#include "graspctx/io/picture.hpp"

namespace graspctx {
namespace {

StereoCamera test_camera(int width_px, int height_px) {
  StereoCamera camera;
  camera.focal_px = 0.94 * width_px;
  camera.centre_px = {0.5 * (width_px - 1), 0.5 * (height_px - 1)};
  camera.baseline_m = 0.08;
  camera.width_px = width_px;
  camera.height_px = height_px;
  return camera;
}

GraspConfiguration grasp_at(const StereoCamera& camera, const Eigen::Vector3d& position_m,
                            const Eigen::Vector3d& approach, const Eigen::Vector3d& closing) {
  GraspConfiguration grasp;
  grasp.rank = 1;
  grasp.probability = 0.93;
  grasp.position_m = position_m;
  grasp.left_px = camera.project(position_m);
  grasp.approach = approach.normalized();
  grasp.closing = closing.normalized();
  grasp.cam_from_hand.block<3, 1>(0, 0) = grasp.closing;
  grasp.cam_from_hand.block<3, 1>(0, 1) = grasp.approach.cross(grasp.closing);
  grasp.cam_from_hand.block<3, 1>(0, 2) = grasp.approach;
  grasp.cam_from_hand.block<3, 1>(0, 3) = position_m;
  grasp.opening_m = 0.06;
  return grasp;
}

/// A grey scene with one disc as its object, and a grasp from above at its upper rim.
Detection test_detection(const StereoCamera& camera) {
  const cv::Size size(camera.width_px, camera.height_px);
  Detection detection;
  detection.image_size = size;
  detection.pair.left = cv::Mat(size, CV_8UC3, cv::Scalar::all(100));
  detection.pair.right = detection.pair.left.clone();
  detection.segmentation.instance_ids = cv::Mat::zeros(size, CV_8UC1);
  const cv::Point centre(size.width / 2, size.height / 2);
  const int radius = size.height / 6;
  cv::circle(detection.segmentation.instance_ids, centre, radius, 1, cv::FILLED);

  DetectedObject object;
  object.id = 1;
  object.bounding_box_px = cv::boundingRect(detection.segmentation.instance_ids);
  object.intermediates.fovea.left = foveal_view(detection.pair.left, detection.segmentation.instance_ids);
  const FovealView& view = object.intermediates.fovea.left;
  object.intermediates.contour = sample_contour(view.image, view.mask);
  object.intermediates.patches = patch_descriptors(object.intermediates.contour, view.image.size());
  object.intermediates.probabilities =
      Eigen::VectorXd::LinSpaced(object.intermediates.patches.features.rows(), 0, 1);
  const Eigen::Vector2d top_px(centre.x, centre.y - radius);
  object.grasps.push_back(
      grasp_at(camera, camera.triangulate(top_px, camera.disparity_px(0.7)), {0, 0.9, 0.3}, {1, 0, 0}));
  detection.objects.push_back(object);
  return detection;
}

int coloured_pixels(const cv::Mat& picture) {
  std::vector<cv::Mat> channels;
  cv::split(picture, channels);
  cv::Mat low, high;
  cv::min(channels[0], channels[1], low);
  cv::min(low, channels[2], low);
  cv::max(channels[0], channels[1], high);
  cv::max(high, channels[2], high);
  return cv::countNonZero(high - low > 3);
}

PictureOptions only_grasps() {
  PictureOptions options;
  options.contour = options.probabilities = options.pose = false;
  return options;
}

TEST(Picture, EnlargesSmallImagesAndLeavesLargeOnes) {
  const StereoCamera small = test_camera(463, 370), large = test_camera(1280, 960);
  EXPECT_EQ(draw_detection(test_detection(small), small).size(), cv::Size(960, 767));
  EXPECT_EQ(draw_detection(test_detection(large), large).size(), cv::Size(1280, 960));
  EXPECT_EQ(draw_detection(test_detection(small), small).type(), CV_8UC3);
}

TEST(Picture, ATallNarrowImageIsNotEnlargedWithoutLimit) {
  const StereoCamera camera = test_camera(16, 3000);
  Detection detection;
  detection.pair.left = cv::Mat(3000, 16, CV_8UC3, cv::Scalar::all(100));
  EXPECT_EQ(draw_detection(detection, camera).size(), cv::Size(87, 16384));  // not 960 by 180000
}

TEST(Picture, NothingFoundIsTheImageItself) {
  const StereoCamera camera = test_camera(1000, 700);
  Detection detection;
  detection.pair.left = cv::Mat(700, 1000, CV_8UC3);
  cv::randu(detection.pair.left, 0, 255);
  const cv::Mat picture = draw_detection(detection, camera);
  EXPECT_EQ(cv::norm(picture, detection.pair.left, cv::NORM_INF), 0);
  EXPECT_NE(picture.data, detection.pair.left.data);
}

TEST(Picture, AxesEndWhereTheCameraSeesThem) {
  const StereoCamera camera = test_camera(1280, 960);
  Detection detection = test_detection(camera);
  GraspConfiguration& grasp = detection.objects[0].grasps[0];
  grasp = grasp_at(camera, {-0.05, 0.02, 0.7}, {0.2, 0.5, 0.6}, {1, 0, -0.3333});
  const cv::Mat picture = draw_detection(detection, camera, only_grasps());
  // BGR channel that must dominate along each axis: x red, y green, z blue.
  for (const auto& [axis, channel] : {std::pair(0, 2), std::pair(1, 1), std::pair(2, 0)}) {
    const Eigen::Vector3d direction = grasp.cam_from_hand.block<3, 1>(0, axis);
    for (const double distance_m : {0.02, 0.035, 0.048}) {
      const Eigen::Vector2d px = camera.project(grasp.position_m + distance_m * direction);
      const auto colour = picture.at<cv::Vec3b>(cvRound(px.y()), cvRound(px.x()));
      for (int other = 0; other < 3; ++other) {
        if (other == channel) continue;
        EXPECT_GT(colour[channel], colour[other] + 60) << "axis " << axis << " at " << distance_m << " m";
      }
    }
  }
}

TEST(Picture, TheHandStandsBehindTheGraspPointAgainstTheApproach) {
  const StereoCamera camera = test_camera(1280, 960);
  Detection detection = test_detection(camera);
  const cv::Mat with_hand = draw_detection(detection, camera, only_grasps());
  // From above: the hand reaches a finger's length up in the image, and less than an axis's length down.
  Detection without = detection;
  without.objects[0].grasps.clear();
  cv::Mat changed;
  cv::absdiff(with_hand, draw_detection(without, camera, only_grasps()), changed);
  cv::cvtColor(changed, changed, cv::COLOR_BGR2GRAY);
  const cv::Rect box = cv::boundingRect(changed > 8);
  const GraspConfiguration& grasp = detection.objects[0].grasps[0];
  const double px_per_m = camera.focal_px / grasp.position_m.z();
  EXPECT_LT(box.y, grasp.left_px.y() - 0.09 * px_per_m);
  EXPECT_GT(box.y, grasp.left_px.y() - 0.20 * px_per_m);
  EXPECT_LT(box.y + box.height, grasp.left_px.y() + 0.08 * px_per_m);
}

TEST(Picture, InfeasibleGraspsAreGrey) {
  const StereoCamera camera = test_camera(1280, 960);
  Detection detection = test_detection(camera);
  detection.segmentation.instance_ids = cv::Mat();  // without the segment's tint all colour is the grasp's
  PictureOptions options = only_grasps();
  const int feasible = coloured_pixels(draw_detection(detection, camera, options));
  detection.objects[0].grasps[0].feasible = false;
  detection.objects[0].grasps[0].infeasible_because = "the thumb would go through the table";
  const int infeasible = coloured_pixels(draw_detection(detection, camera, options));
  EXPECT_GT(feasible, 2000);
  EXPECT_LT(infeasible, feasible / 4);  // the label's frame keeps the object's colour
}

TEST(Picture, HandsOfUnlikelyObjectsAreFaint) {
  const StereoCamera camera = test_camera(1280, 960);
  Detection detection = test_detection(camera);
  detection.segmentation.instance_ids = cv::Mat();
  detection.objects.push_back(detection.objects[0]);
  std::vector<cv::Rect> palms;
  for (const int i : {0, 1}) {
    const Eigen::Vector3d position_m(0.3 * i - 0.15, 0.05, 0.7);
    GraspConfiguration& grasp = detection.objects[i].grasps[0];
    grasp = grasp_at(camera, position_m, {0, 1, 0}, {1, 0, 0});
    const Eigen::Vector2d palm_px = camera.project(position_m - Eigen::Vector3d(0, 0.125, 0));
    palms.emplace_back(cvRound(palm_px.x()) - 10, cvRound(palm_px.y()) - 5, 20, 10);
  }
  detection.objects[0].grasps[0].probability = 0.9;
  detection.objects[1].grasps[0].probability = 0.3;
  cv::Mat changed;
  cv::absdiff(draw_detection(detection, camera, only_grasps()), detection.pair.left, changed);
  const double likely = cv::mean(changed(palms[0]))[0], unlikely = cv::mean(changed(palms[1]))[0];
  EXPECT_GT(likely, 30);
  EXPECT_GT(unlikely, 2);
  EXPECT_LT(unlikely, likely / 3);
}

TEST(Picture, WhatLiesBehindTheCameraIsLeftOut) {
  const StereoCamera camera = test_camera(640, 480);
  Detection detection = test_detection(camera);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Eigen::Vector3d> positions{{0, 0, -0.5}, {0, 0, 0},       {0.01, 0, 0.05}, {5, 5, 0.021},
                                               {1e9, 0, 1},  {nan, nan, nan}, {0, 0, 1e-300}};
  for (const Eigen::Vector3d& position_m : positions) {
    GraspConfiguration grasp = grasp_at(camera, position_m, {0, 0.1, 1}, {1, 0, 0});
    grasp.rank = static_cast<int>(detection.objects[0].grasps.size()) + 1;
    detection.objects[0].grasps.push_back(grasp);
  }
  PictureOptions options;
  options.max_grasps = 100;
  ObjectPose pose;
  pose.centroid_m = {0, 0, 0.01};
  pose.major_axis_m = {0, 0, 0.1};
  pose.minor_axis_m = {0.1, 0, 0};
  detection.objects[0].pose = pose;
  const cv::Mat picture = draw_detection(detection, camera, options);
  EXPECT_EQ(picture.size(), cv::Size(960, 720));

  // A hand wholly behind the camera changes nothing; nor does a label whose point is outside.
  for (GraspConfiguration& grasp : detection.objects[0].grasps) {
    grasp.cam_from_hand(2, 3) = -1;
    grasp.left_px = {-100, -100};
  }
  Detection without = detection;
  without.objects[0].grasps.clear();
  EXPECT_EQ(cv::norm(draw_detection(detection, camera, only_grasps()),
                     draw_detection(without, camera, only_grasps()), cv::NORM_INF),
            0);
}

TEST(Picture, PatchesAreColouredWhereTheFoveaSawThem) {
  const StereoCamera camera = test_camera(1280, 960);
  Detection detection = test_detection(camera);
  detection.objects[0].grasps.clear();
  detection.segmentation.instance_ids = cv::Mat();
  ObjectIntermediates& seen = detection.objects[0].intermediates;
  seen.probabilities.setZero();
  const Eigen::Index marked = seen.probabilities.size() / 3;
  seen.probabilities[marked] = 1;
  PictureOptions options;
  options.contour = false;
  const cv::Mat picture = draw_detection(detection, camera, options);
  // The mark is the one bright patch; its mean position is the patch's centre carried back to the image.
  cv::Mat yellow;
  cv::inRange(picture(cv::Rect(0, 0, 1100, 800)), cv::Scalar(0, 180, 180), cv::Scalar(120, 255, 255), yellow);
  const cv::Moments moments = cv::moments(yellow, true);
  const cv::Point2f centre = seen.patches.centres_px[static_cast<std::size_t>(marked)];
  const Eigen::Vector2d expected = seen.fovea.left.image_from_view({centre.x, centre.y});
  EXPECT_NEAR(moments.m10 / moments.m00, expected.x(), 0.75);
  EXPECT_NEAR(moments.m01 / moments.m00, expected.y(), 0.75);
  EXPECT_NEAR(moments.m00, std::pow(10 / seen.fovea.left.scale, 2), 0.2 * moments.m00);
}

TEST(Picture, TheSameDetectionGivesTheSameBytesAndStaysAsItWas) {
  const StereoCamera camera = test_camera(640, 480);
  const Detection detection = test_detection(camera);
  const cv::Mat left = detection.pair.left.clone(), ids = detection.segmentation.instance_ids.clone();
  const cv::Mat first = draw_detection(detection, camera), second = draw_detection(detection, camera);
  EXPECT_EQ(cv::norm(first, second, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(detection.pair.left, left, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(detection.segmentation.instance_ids, ids, cv::NORM_INF), 0);
}

TEST(Picture, GreyImagesAreDrawnInColour) {
  const StereoCamera camera = test_camera(640, 480);
  Detection detection = test_detection(camera);
  cv::cvtColor(detection.pair.left, detection.pair.left, cv::COLOR_BGR2GRAY);
  const cv::Mat picture = draw_detection(detection, camera);
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_GT(coloured_pixels(picture), 1000);
}

TEST(Picture, RefusesWhatCannotBeDrawn) {
  const StereoCamera camera = test_camera(640, 480);
  EXPECT_THROW(draw_detection({}, camera), InvalidInput);
  const Detection detection = test_detection(camera);
  PictureOptions options;
  options.max_grasps = -1;
  EXPECT_THROW(draw_detection(detection, camera, options), InvalidInput);
  options = {};
  options.min_width_px = 0;
  EXPECT_THROW(draw_detection(detection, camera, options), InvalidInput);
  EXPECT_THROW(draw_detection(detection, StereoCamera{}), InvalidInput);
  Detection other_size = detection;
  other_size.segmentation.instance_ids = cv::Mat::zeros(10, 10, CV_8UC1);
  EXPECT_THROW(draw_detection(other_size, camera), InvalidInput);
}

}  // namespace
}  // namespace graspctx
