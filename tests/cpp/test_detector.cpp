#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "graspctx/detector.hpp"
#include "graspctx/error.hpp"
#include "graspctx/evaluation.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;

/// A block with a slab standing out at its side, to be grasped there: two boxes, one object.
struct Handled {
  CastScene scene;
  cv::Mat mask, handle;
  Eigen::Vector3d handle_m;  // middle of the slab, camera frame
};

Handled handled_block(double turn_rad, double scale = 1,
                      const Eigen::Isometry3d& view = testing::look_at_table()) {
  const Eigen::AngleAxisd turn(turn_rad, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d colour(60, 90, 190);
  const Box body{{0, 0, 0.045 * scale}, Eigen::Vector3d(0.035, 0.035, 0.045) * scale, turn_rad, colour};
  const Eigen::Vector3d beside = turn * Eigen::Vector3d(0.053 * scale, 0, 0.05 * scale);
  const Box slab{beside, Eigen::Vector3d(0.018, 0.008, 0.02) * scale, turn_rad, colour};
  Handled object;
  object.scene = testing::cast_scene(testing::test_camera(), {body, slab}, view);
  object.mask = (object.scene.instance_ids > 0) / 255;
  object.handle = object.scene.instance_ids == 2;
  object.handle_m = view * beside;
  return object;
}

LabelledView labelled(const Handled& object, int group) {
  return {"cast scene", "block", group, object.scene.pair.left, object.mask, object.handle};
}

const TrainingSet& block_set() {
  static const TrainingSet rows = [] {
    std::vector<LabelledView> views;
    for (int i = 0; i < 12; ++i) {
      views.push_back(labelled(handled_block(-1.1 + 0.2 * i, 0.85 + 0.03 * (i % 5)), i));
    }
    AugmentOptions true_masks;  // ctest runs each test on its own: keep what they share small
    true_masks.degraded_masks = 0;
    return build_training_set(views, {}, true_masks);
  }();
  return rows;
}

const GraspModel& block_model() {
  static const GraspModel model = [] {
    const TrainingSet& set = block_set();
    TrainOptions options;
    options.max_rows = 1000;
    options.svm_c = {10};
    options.gamma_times_dimension = {1};
    GraspModel trained = train_model(set.features, set.labels, set.groups, options);
    trained.name = "block";
    trained.classes = {"block"};
    return trained;
  }();
  return model;
}

Detection detect(const Handled& object, const DetectorOptions& options = {}) {
  const RectifiedPair& pair = object.scene.pair;
  return detect_grasps(pair.left, pair.right, testing::test_camera(), block_model(), options, object.mask);
}

/// The same model, taught that its objects look like blocks whose descriptors differ by `shift`.
GraspModel taught(const std::string& name, float shift) {
  const TrainingSet& set = block_set();
  GraspModel model = block_model();
  model.name = name;
  const FeatureMatrix shifted = set.features.array() + shift;
  model.familiarity = learn_familiarity(shifted, set.views, set.groups);
  return model;
}

Detection detect_with(const Handled& object, const std::vector<GraspModel>& models,
                      const DetectorOptions& options = {}) {
  const RectifiedPair& pair = object.scene.pair;
  return detect_grasps(pair.left, pair.right, testing::test_camera(), models, options, object.mask);
}

TEST(Detector, FindsTheHandleOfAnUnseenBlock) {
  const Handled object = handled_block(0.42, 1.05, testing::look_at_table(0.75, 0.65, -0.04));
  const Detection detection = detect(object);
  ASSERT_EQ(detection.objects.size(), 1u);
  const DetectedObject& found = detection.objects[0];
  ASSERT_FALSE(found.grasps.empty());
  ASSERT_TRUE(found.pose);
  ASSERT_TRUE(detection.segmentation.table);
  EXPECT_NEAR(detection.segmentation.table->offset_m, object.scene.table.offset_m, 0.003);
  const GraspConfiguration& best = found.grasps[0];
  EXPECT_LT((best.position_m - object.handle_m).norm(), 0.03);
  EXPECT_GT(best.probability, 0.2);

  bool was_feasible = true;
  double last = 1;
  for (std::size_t i = 0; i < found.grasps.size(); ++i) {
    const GraspConfiguration& grasp = found.grasps[i];
    EXPECT_EQ(grasp.rank, static_cast<int>(i) + 1);
    EXPECT_DOUBLE_EQ(grasp.probability, grasp.probability_left * grasp.probability_right);  // Eq. 1
    EXPECT_TRUE(was_feasible || !grasp.feasible);
    EXPECT_TRUE(was_feasible != grasp.feasible || grasp.probability <= last);  // Eq. 2
    EXPECT_NEAR(grasp.approach.norm(), 1, 1e-9);
    EXPECT_NEAR(grasp.closing.norm(), 1, 1e-9);
    EXPECT_NEAR(grasp.approach.dot(grasp.closing), 0, 1e-9);
    EXPECT_EQ(grasp.feasible, !grasp.infeasible_because);
    EXPECT_LT((testing::test_camera().project(grasp.position_m) - grasp.left_px).norm(), 1e-6);
    was_feasible = grasp.feasible;
    last = grasp.probability;
  }
}

TEST(Detector, AShiftOfBothImagesShiftsTheGrasp) {
  const Handled object = handled_block(0.42);
  const int du = -23, dv = 14;
  const auto shifted = [&](const cv::Mat& image) {
    cv::Mat result;
    cv::warpAffine(image, result, cv::Matx23d(1, 0, du, 0, 1, dv), image.size(), cv::INTER_NEAREST,
                   image.channels() == 3 ? cv::BORDER_REFLECT : cv::BORDER_CONSTANT);
    return result;
  };
  const Detection here = detect(object);
  const Detection there = detect_grasps(shifted(object.scene.pair.left), shifted(object.scene.pair.right),
                                        testing::test_camera(), block_model(), {}, shifted(object.mask));
  ASSERT_FALSE(here.objects.at(0).grasps.empty());
  ASSERT_FALSE(there.objects.at(0).grasps.empty());
  // The left view is the same to the bit, and so is its response.
  const ObjectIntermediates &left = here.objects[0].intermediates, &moved = there.objects[0].intermediates;
  EXPECT_EQ(left.patches.cells, moved.patches.cells);
  ASSERT_EQ(left.probabilities.size(), moved.probabilities.size());
  EXPECT_EQ((left.probabilities - moved.probabilities).cwiseAbs().maxCoeff(), 0);
  // The borders show something else, so a disparity, and with it a match, may differ: not where a grasp is,
  // though.
  int compared = 0;
  for (const GraspConfiguration& a : here.objects[0].grasps) {
    for (const GraspConfiguration& b : there.objects[0].grasps) {
      if ((a.left_px + Eigen::Vector2d(du, dv) - b.left_px).norm() > 0.01) continue;
      EXPECT_LT((a.right_px + Eigen::Vector2d(du, dv) - b.right_px).norm(), 0.5);
      EXPECT_EQ(a.probability_left, b.probability_left);
      EXPECT_NEAR(a.opening_m, b.opening_m, 1e-3);
      ++compared;
    }
  }
  EXPECT_GT(compared, 0);
}

TEST(Detector, IsTheSameForAnyNumberOfThreads) {
  const Handled object = handled_block(0.1);
  cv::Mat mask = object.scene.instance_ids;  // body and slab as two objects
  const RectifiedPair& pair = object.scene.pair;
  const auto run = [&](int threads) {
    DetectorOptions options;
    options.threads = threads;
    return detect_grasps(pair.left, pair.right, testing::test_camera(), block_model(), options, mask);
  };
  const Detection one = run(1);
  EXPECT_EQ(one.objects.size(), 2u);
  for (const int threads : {2, 4}) {
    const Detection many = run(threads);
    ASSERT_EQ(many.objects.size(), one.objects.size());
    for (std::size_t i = 0; i < one.objects.size(); ++i) {
      EXPECT_EQ(many.objects[i].id, one.objects[i].id);
      ASSERT_EQ(many.objects[i].grasps.size(), one.objects[i].grasps.size());
      for (std::size_t g = 0; g < one.objects[i].grasps.size(); ++g) {
        EXPECT_EQ(many.objects[i].grasps[g].cam_from_hand, one.objects[i].grasps[g].cam_from_hand);
        EXPECT_EQ(many.objects[i].grasps[g].probability, one.objects[i].grasps[g].probability);
      }
    }
  }
}

TEST(Detector, AnEmptyMaskHoldsNothing) {
  const Handled object = handled_block(0.1);
  const RectifiedPair& pair = object.scene.pair;
  const Detection detection = detect_grasps(pair.left, pair.right, testing::test_camera(), block_model(), {},
                                            cv::Mat::zeros(480, 640, CV_8UC1));
  EXPECT_TRUE(detection.objects.empty());
}

TEST(Detector, DoubtsAPairThatIsNoneAlsoWhenTheCallerGivesTheMask) {
  const Handled object = handled_block(0.3);
  const RectifiedPair& pair = object.scene.pair;
  EXPECT_TRUE(detect(object).warnings.empty());
  ASSERT_TRUE(detect(object).segmentation.vertical_offset_px);
  const Detection swapped =
      detect_grasps(pair.right, pair.left, testing::test_camera(), block_model(), {}, object.mask);
  ASSERT_FALSE(swapped.warnings.empty());
  EXPECT_NE(swapped.warnings.back().find("not a rectified stereo pair"), std::string::npos);
  cv::Mat lower;
  cv::warpAffine(pair.right, lower, cv::Matx23d(1, 0, 0, 0, 1, 2), pair.right.size());
  const Detection misaligned =
      detect_grasps(pair.left, lower, testing::test_camera(), block_model(), {}, object.mask);
  ASSERT_FALSE(misaligned.warnings.empty());
  EXPECT_NE(misaligned.warnings.front().find("misaligned vertically by 2 px"), std::string::npos);
}

TEST(Detector, KeepsAtMostAsManyGraspsAsAsked) {
  DetectorOptions options;
  options.max_grasps = 1;
  EXPECT_LE(detect(handled_block(0.3), options).objects.at(0).grasps.size(), 1u);
}

TEST(Detector, OfSeveralModelsTheOneThatKnowsTheObjectAnswers) {
  const Handled object = handled_block(0.42);
  const Detection alone = detect(object);
  GraspModel other = taught("other", 0.3f);
  other.rho += 1;  // its grasps would be others
  GraspModel coarse = taught("coarse", 0.3f);
  coarse.descriptor.contour.samples = 100;  // describes the views in another way
  for (const auto& models :
       {std::vector{taught("block", 0), other, coarse}, std::vector{coarse, other, taught("block", 0)}}) {
    const DetectedObject found = detect_with(object, models).objects.at(0);
    EXPECT_EQ(found.model_name, "block");
    ASSERT_TRUE(found.familiarity);
    EXPECT_GT(*found.familiarity, default_min_familiarity);
    EXPECT_FALSE(found.unfamiliar);
    ASSERT_EQ(found.grasps.size(), alone.objects.at(0).grasps.size());
    for (std::size_t g = 0; g < found.grasps.size(); ++g) {
      EXPECT_EQ(found.grasps[g].cam_from_hand, alone.objects[0].grasps[g].cam_from_hand);
      EXPECT_EQ(found.grasps[g].probability, alone.objects[0].grasps[g].probability);
    }
  }
}

TEST(Detector, WhatNoModelKnowsIsNotGrasped) {
  const Handled object = handled_block(0.42);
  DetectorOptions options;
  options.min_familiarity = 0.3;  // a dozen views cannot tell less than 1 in 13
  const std::vector<GraspModel> models{taught("far", 0.5f), taught("near", 0.3f)};
  const DetectedObject refused = detect_with(object, models, options).objects.at(0);
  EXPECT_TRUE(refused.unfamiliar);
  EXPECT_EQ(refused.model_name, "near");
  EXPECT_TRUE(refused.grasps.empty());
  EXPECT_TRUE(refused.pose);
  EXPECT_EQ(refused.intermediates.probabilities.size(), 0);
  options.min_familiarity = 0;
  EXPECT_FALSE(detect_with(object, models, options).objects.at(0).grasps.empty());
  // One model reports, and refuses only if it is told to.
  options.min_familiarity.reset();
  const DetectedObject reported = detect_with(object, {models[1]}, options).objects.at(0);
  EXPECT_EQ(reported.familiarity, refused.familiarity);
  EXPECT_FALSE(reported.unfamiliar);
  EXPECT_FALSE(reported.grasps.empty());
  options.min_familiarity = 0.3;
  EXPECT_TRUE(detect_with(object, {models[1]}, options).objects.at(0).unfamiliar);
}

TEST(Detector, RefusesModelsThatCannotVote) {
  const Handled object = handled_block(0.42);
  EXPECT_THROW(detect_with(object, {}), InvalidInput);
  EXPECT_THROW(detect_with(object, {taught("block", 0), taught("block", 0.3f)}), InvalidInput);
  EXPECT_THROW(detect_with(object, {taught("other", 0), block_model()}), InvalidInput);
  DetectorOptions options;
  options.min_familiarity = 0.1;
  EXPECT_THROW(detect_with(object, {block_model()}, options), InvalidInput);
  options.min_familiarity = 0;
  const DetectedObject found = detect_with(object, {block_model()}, options).objects.at(0);
  EXPECT_FALSE(found.familiarity);
  EXPECT_EQ(found.model_name, "");
  options.min_familiarity = 1.5;
  EXPECT_THROW(detect_with(object, {taught("block", 0)}, options), InvalidInput);
}

TEST(Detector, RefusesBadInput) {
  const cv::Mat image(480, 640, CV_8UC3, cv::Scalar(0)), small(240, 320, CV_8UC3, cv::Scalar(0));
  const StereoCamera camera = testing::test_camera();
  EXPECT_THROW(detect_grasps(image, small, camera, block_model()), InvalidInput);
  EXPECT_THROW(detect_grasps(small, small, camera, block_model()),
               InvalidInput);  // not the calibration's size
  EXPECT_THROW(detect_grasps({}, {}, camera, block_model()), InvalidInput);
  EXPECT_THROW(detect_grasps(image, image, {}, block_model()), InvalidInput);
  EXPECT_THROW(detect_grasps(image, image, camera, GraspModel{}), InvalidInput);
  EXPECT_THROW(detect_grasps(image, image, camera, block_model(), {}, cv::Mat::ones(3, 3, CV_8UC1)),
               InvalidInput);
  DetectorOptions options;
  options.max_grasps = 0;
  EXPECT_THROW(detect_grasps(image, image, camera, block_model(), options), InvalidInput);
}

TEST(Dataset, PatchesThatOverlapTheLabelArePositive) {
  const Handled object = handled_block(0.42);
  const LabelledPatches described = describe_labelled_view(labelled(object, 0));
  ASSERT_GT(described.labels.size(), 20u);
  const FovealView view = foveal_view(object.scene.pair.left, object.mask);
  int positives = 0;
  for (std::size_t m = 0; m < described.labels.size(); ++m) {
    // A patch whose middle lies on the label overlaps it; one far from it does not.
    const cv::Point2f& c = described.patches.centres_px[m];
    const Eigen::Vector2d at = view.image_from_view({c.x, c.y});
    cv::Mat near;
    const int reach = static_cast<int>(std::ceil(8 / view.scale));
    cv::getRectSubPix(object.handle, {2 * reach + 1, 2 * reach + 1},
                      {static_cast<float>(at.x()), static_cast<float>(at.y())}, near);
    if (object.handle.at<uchar>(
            cv::Point(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y()))))) {
      EXPECT_EQ(described.labels[m], 1);
    }
    EXPECT_TRUE(cv::countNonZero(near) > 0 || described.labels[m] == 0);
    EXPECT_EQ(described.labels[m] == 1, described.label_share[m] > 0);
    positives += described.labels[m];
  }
  EXPECT_GT(positives, 3);
  EXPECT_LT(positives, static_cast<int>(described.labels.size()) / 2);
}

TEST(Dataset, DegradedMasksAddRowsOfTheSameGroup) {
  const std::vector<LabelledView> views{labelled(handled_block(0.2), 4), labelled(handled_block(0.6), 9)};
  AugmentOptions none, two;
  none.degraded_masks = 0;
  two.degraded_masks = 2;
  const TrainingSet plain = build_training_set(views, {}, none),
                    augmented = build_training_set(views, {}, two);
  EXPECT_EQ(plain.features.rows(), static_cast<Eigen::Index>(plain.labels.size()));
  EXPECT_GT(augmented.labels.size(), 2 * plain.labels.size());
  EXPECT_EQ(augmented.groups.front(), 4);
  ASSERT_EQ(augmented.views.size(), augmented.labels.size());
  EXPECT_TRUE(std::is_sorted(augmented.views.begin(), augmented.views.end()));
  EXPECT_EQ(augmented.views.back(), 5);  // two views with three masks each
  EXPECT_EQ(plain.views.back(), 1);
  EXPECT_EQ(augmented.groups.back(), 9);
  EXPECT_EQ((build_training_set(views, {}, two).features - augmented.features).cwiseAbs().maxCoeff(), 0);
  LabelledView broken = views[0];
  broken.label = cv::Mat::zeros(10, 10, CV_8UC1);
  EXPECT_THROW(build_training_set({broken}), InvalidInput);
}

}  // namespace
}  // namespace graspctx
