// What a grasp rests on: against a plain second implementation, closed forms and known training patches.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "graspctx/error.hpp"
#include "graspctx/explanation.hpp"
#include "graspctx/io/explanation_json.hpp"
#include "graspctx/io/picture.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

DescriptorOptions few_samples() {
  DescriptorOptions options;
  options.contour.samples = 70;
  return options;
}

FovealView mug_view(int unit = 60, const cv::Point& at = {260, 200}) {
  const testing::DrawnMug mug = testing::draw_mug({640, 480}, at, unit);
  return foveal_view(mug.image, mug.mask);
}

/// A described view and a model whose support vectors are patches of it, of both labels in turn.
struct Scene {
  FovealView view;
  Contour contour;
  PatchDescriptors patches;
  GraspModel model;
};

GraspModel model_of(const FeatureMatrix& rows, const DescriptorOptions& options) {
  GraspModel model;
  model.name = "mug";
  model.classes = {"mug"};
  model.descriptor = options;
  model.mean = rows.colwise().mean().transpose();
  model.scale = Eigen::VectorXf::LinSpaced(rows.cols(), 0.05f, 0.3f);
  model.svm_c = 5;
  model.gamma = 0.3 / static_cast<double>(rows.cols());
  const Eigen::Index count = rows.rows() / 2;
  model.support_vectors.resize(2 * count, rows.cols());
  model.coefficients.resize(2 * count);
  for (Eigen::Index i = 0; i < 2 * count; ++i) {
    const Eigen::Index row = i < count ? 2 * i : 2 * (i - count) + 1;
    model.support_vectors.row(i) =
        (rows.row(row) - model.mean.transpose()).cwiseQuotient(model.scale.transpose());
    model.coefficients[i] = (i < count ? 1 : -1) * (0.5 + 0.1 * static_cast<double>(i % 7));
  }
  model.rho = 0.2;
  model.sigmoid_a = -1.5;
  model.sigmoid_b = 0.1;
  return model;
}

Scene mug_scene(const DescriptorOptions& options = few_samples()) {
  Scene scene;
  scene.view = mug_view();
  scene.contour = sample_contour(scene.view.image, scene.view.mask, options.contour);
  scene.patches = patch_descriptors(scene.contour, scene.view.image.size(), options);
  scene.model = model_of(scene.patches.features, options);
  return scene;
}

PatchExplanation explain(const Scene& scene, int patch, const ExplanationOptions& options = {}) {
  return explain_patch(scene.contour, scene.patches.centres_px[static_cast<std::size_t>(patch)],
                       scene.patches.features.row(patch), scene.model, options);
}

double decision_value(const GraspModel& model, const Eigen::RowVectorXf& row) {
  return model.decision_values(row)[0];
}

/// The descriptor of a patch by its definition, without one sample; the unit is that of all samples.
Eigen::RowVectorXf descriptor_without(std::size_t left_out, const Contour& contour,
                                      const cv::Point2f& centre_px, const DescriptorOptions& options) {
  const std::vector<cv::Point2f>& points = contour.points;
  double sum = 0, pairs = 0;
  for (const cv::Point2f& a : points) {
    for (const cv::Point2f& b : points) {
      sum += std::hypot(a.x - b.x, a.y - b.y);
      pairs += &a != &b ? 1 : 0;
    }
  }
  const double unit = sum / pairs;
  const ShapeContextOptions& shape = options.shape_context;
  const int plain = shape.angular_bins * shape.radial_bins;
  Eigen::RowVectorXd feature = Eigen::RowVectorXd::Zero(3 * shape.bins());
  for (int scale = 0; scale < 3; ++scale) {
    Eigen::RowVectorXd histogram = Eigen::RowVectorXd::Zero(shape.bins());
    const double half =
        0.5 * options.patch.patch_px * options.patch.windows_patches[static_cast<std::size_t>(scale)];
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double du = points[i].x - centre_px.x, dv = points[i].y - centre_px.y;
      if (i == left_out || du < -half || du >= half || dv < -half || dv >= half) continue;
      for (std::size_t j = 0; j < points.size(); ++j) {
        if (j == i || j == left_out) continue;
        const double x = points[j].x - points[i].x, y = points[j].y - points[i].y;
        const double radius = std::hypot(x, y) / unit;
        if (radius >= shape.outer_radius) continue;
        int ring = 0;
        if (radius >= shape.inner_radius) {
          ring = 1 +
                 static_cast<int>(std::floor((shape.radial_bins - 1) * std::log(radius / shape.inner_radius) /
                                             std::log(shape.outer_radius / shape.inner_radius)));
        }
        double angle = std::atan2(y, x);
        if (shape.relative_to_gradient) angle -= contour.gradients_rad[i];
        while (angle < 0) angle += 2 * CV_PI;
        while (angle >= 2 * CV_PI) angle -= 2 * CV_PI;
        const int sector = static_cast<int>(angle / (2 * CV_PI) * shape.angular_bins);
        histogram[sector * shape.radial_bins + ring] += 1;
        if (shape.outline_px > 0 && contour.border_px[j] <= static_cast<float>(shape.outline_px)) {
          histogram[plain + sector * shape.radial_bins + ring] += 1;
        }
      }
    }
    if (histogram.sum() > 0) histogram = (histogram / histogram.sum()).cwiseSqrt();
    feature.segment(scale * shape.bins(), shape.bins()) = histogram;
  }
  return feature.cast<float>();
}

TEST(Explanation, PointEffectsAreThoseOfADescriptorMadeWithoutThem) {
  DescriptorOptions outline = few_samples(), turned = few_samples();
  outline.shape_context.outline_px = 4;
  turned.shape_context.relative_to_gradient = true;
  turned.patch.windows_patches = {1, 5, 11};
  for (const DescriptorOptions& options : {few_samples(), outline, turned}) {
    const Scene scene = mug_scene(options);
    for (const int patch : {0, static_cast<int>(scene.patches.features.rows()) / 2}) {
      const PatchExplanation found = explain(scene, patch);
      const cv::Point2f centre_px = scene.patches.centres_px[static_cast<std::size_t>(patch)];
      const Eigen::RowVectorXf whole = descriptor_without(none, scene.contour, centre_px, options);
      ASSERT_LT((whole - scene.patches.features.row(patch)).cwiseAbs().maxCoeff(), 1e-6);
      ASSERT_EQ(found.point_effects.size(), scene.contour.points.size());
      double largest = 0;
      for (std::size_t i = 0; i < found.point_effects.size(); ++i) {
        const double without =
            decision_value(scene.model, descriptor_without(i, scene.contour, centre_px, options));
        EXPECT_NEAR(found.point_effects[i], found.decision_value - without, 1e-5) << i;
        largest = std::max(largest, std::abs(found.point_effects[i]));
      }
      EXPECT_GT(largest, 1e-3);  // there was something to find
    }
  }
}

TEST(Explanation, PointsThatNoHistogramCountsHaveNoEffect) {
  DescriptorOptions options = few_samples();
  options.shape_context.inner_radius = 0.05;
  options.shape_context.outer_radius = 0.3;
  const Scene scene = mug_scene(options);
  const PatchExplanation found = explain(scene, 0);
  int far_away = 0;
  const double reach_px = 0.5 * 7 * 10 * std::sqrt(2.0) + found.ring_radii_px.back();
  for (std::size_t i = 0; i < found.point_effects.size(); ++i) {
    if (cv::norm(scene.contour.points[i] - found.centre_px) < reach_px) continue;
    EXPECT_EQ(found.point_effects[i], 0);
    ++far_away;
  }
  EXPECT_GT(far_away, 10);
}

TEST(Explanation, BinEffectsFollowTheKernelsClosedForm) {
  DescriptorOptions options = few_samples();
  options.shape_context.outline_px = 4;
  const Scene scene = mug_scene(options);
  const PatchExplanation found = explain(scene, 3);
  const GraspModel& model = scene.model;
  EXPECT_NEAR(found.decision_value, decision_value(model, scene.patches.features.row(3)), 1e-12);
  EXPECT_NEAR(found.probability, model.predict_probability(scene.patches.features.row(3))[0], 1e-12);
  ASSERT_EQ(found.bin_effects.size(), options.dimension());
  EXPECT_FALSE(found.other_effect);
  const Eigen::RowVectorXd x = (scene.patches.features.row(3) - model.mean.transpose())
                                   .cwiseQuotient(model.scale.transpose())
                                   .cast<double>();
  const FeatureMatrix& s = model.support_vectors;
  for (Eigen::Index bin = 0; bin < x.size(); ++bin) {
    double change = 0;  // of f, when x'_bin goes to 0: each kernel value by a factor
    for (Eigen::Index i = 0; i < s.rows(); ++i) {
      const double kernel = std::exp(-model.gamma * (x - s.row(i).cast<double>()).squaredNorm());
      const double factor =
          std::exp(model.gamma * (std::pow(x[bin] - s(i, bin), 2) - std::pow(s(i, bin), 2)));
      change += model.coefficients[i] * kernel * (factor - 1);
    }
    EXPECT_NEAR(found.bin_effects[bin], -change, 1e-5) << bin;
  }
  EXPECT_GT(found.bin_effects.cwiseAbs().maxCoeff(), 1e-3);
}

TEST(Explanation, ColumnsBehindTheShapeContextStayAsTheyAre) {
  const Scene scene = mug_scene();
  FeatureMatrix wider(scene.patches.features.rows(), scene.patches.features.cols() + 9);
  wider.leftCols(120) = scene.patches.features;
  for (Eigen::Index row = 0; row < wider.rows(); ++row) {
    for (Eigen::Index i = 0; i < 9; ++i) wider(row, 120 + i) = 0.1f * static_cast<float>((row * (i + 2)) % 5);
  }
  const GraspModel model = model_of(wider, few_samples());
  const cv::Point2f centre_px = scene.patches.centres_px[5];
  const PatchExplanation found = explain_patch(scene.contour, centre_px, wider.row(5), model);
  EXPECT_EQ(found.bin_effects.size(), 120);
  for (const std::size_t i : {0u, 20u, 40u}) {
    Eigen::RowVectorXf row = wider.row(5);
    row.head(120) = descriptor_without(i, scene.contour, centre_px, few_samples());
    EXPECT_NEAR(found.point_effects[i], found.decision_value - decision_value(model, row), 1e-5);
  }
  Eigen::RowVectorXf row = wider.row(5);
  row.tail(9) = model.mean.tail(9).transpose();
  ASSERT_TRUE(found.other_effect);
  EXPECT_NEAR(*found.other_effect, found.decision_value - decision_value(model, row), 1e-9);
  EXPECT_GT(std::abs(*found.other_effect), 1e-4);
}

/// Every third support vector from the same image.
void name_images(GraspModel& model, int images) {
  for (int i = 0; i < images; ++i) model.training_images.push_back("scene_" + std::to_string(i));
  for (int i = 0; i < model.coefficients.size(); ++i) model.support_images.push_back(i % images);
}

TEST(Explanation, TheContributionsOfAllImagesMakeUpTheDecisionValue) {
  Scene scene = mug_scene();
  EXPECT_TRUE(explain(scene, 4).graspable.empty());  // a model that does not know its images
  name_images(scene.model, 8);
  ExplanationOptions all;
  all.max_images = 8;
  const PatchExplanation found = explain(scene, 4, all);
  double f = -scene.model.rho;
  int vectors = 0;
  for (const std::vector<NearImage>* images : {&found.graspable, &found.not_graspable}) {
    ASSERT_EQ(images->size(), 8u);
    for (std::size_t i = 0; i < images->size(); ++i) {
      const NearImage& image = (*images)[i];
      EXPECT_EQ(image.contribution > 0, images == &found.graspable);
      EXPECT_EQ(image.name, "scene_" + std::to_string(image.support_vector % 8));
      EXPECT_GE(image.similarity, (*images)[std::min(i + 1, images->size() - 1)].similarity);
      f += image.contribution;
      vectors += image.support_vectors;
    }
  }
  EXPECT_NEAR(f, found.decision_value, 1e-9);
  EXPECT_EQ(vectors, scene.model.coefficients.size());
  // Patch 4 is itself support vector 2, of the positive ones.
  EXPECT_EQ(found.graspable[0].support_vector, 2);
  EXPECT_NEAR(found.graspable[0].similarity, 1, 1e-6);
  EXPECT_LT(found.not_graspable[0].similarity, 1);
  EXPECT_EQ(explain(scene, 4).graspable.size(), 5u);
}

TEST(Explanation, RefusesWhatIsNotOfThatPatch) {
  const Scene scene = mug_scene();
  const auto refuses = [&](const cv::Point2f& centre_px, const Eigen::RowVectorXf& feature,
                           const GraspModel& model, const ExplanationOptions& options = {}) {
    EXPECT_THROW(explain_patch(scene.contour, centre_px, feature, model, options), InvalidInput);
  };
  const Eigen::RowVectorXf feature = scene.patches.features.row(3);
  refuses(scene.patches.centres_px[9], feature, scene.model);
  refuses(scene.patches.centres_px[3], feature.head(60), scene.model);
  GraspModel finer = scene.model;
  finer.descriptor.shape_context.angular_bins = 12;
  refuses(scene.patches.centres_px[3], feature, finer);
  ExplanationOptions no_image;
  no_image.max_images = 0;
  refuses(scene.patches.centres_px[3], feature, scene.model, no_image);
}

DetectedObject detected(const Scene& scene) {
  DetectedObject object;
  object.id = 3;
  object.intermediates = {{scene.view, scene.view, 0},
                          scene.contour,
                          scene.patches,
                          scene.model.predict_probability(scene.patches.features)};
  for (const int patch : {8, 2}) {
    object.grasps.emplace_back();
    GraspConfiguration& grasp = object.grasps.back();
    grasp.rank = static_cast<int>(object.grasps.size());
    grasp.patch = patch;
    grasp.probability_left = object.intermediates.probabilities[patch];
  }
  return object;
}

TEST(Explanation, AGraspIsExplainedByItsPatchInTheLeftView) {
  const Scene scene = mug_scene();
  const DetectedObject object = detected(scene);
  const GraspExplanation found = explain_grasp(object, scene.model, 2);
  EXPECT_EQ(found.object_id, 3);
  EXPECT_EQ(found.grasp.rank, 2);
  EXPECT_EQ(found.patch.centre_px, scene.patches.centres_px[2]);
  EXPECT_EQ(found.patch.point_effects, explain(scene, 2).point_effects);
  for (const int rank : {-1, 0, 3}) EXPECT_THROW(explain_grasp(object, scene.model, rank), InvalidInput);
  GraspModel other = scene.model;
  other.rho += 0.1;
  EXPECT_THROW(explain_grasp(object, other), InvalidInput);
  DetectedObject unknown = object;
  unknown.grasps[0].patch = -1;
  EXPECT_THROW(explain_grasp(unknown, scene.model), InvalidInput);
}

TEST(Explanation, JsonAndPictureHaveTheOutlineApart) {
  DescriptorOptions outline = few_samples();
  outline.shape_context.outline_px = 4;
  const Scene scene = mug_scene(outline), plain = mug_scene();
  const GraspExplanation found = explain_grasp(detected(scene), scene.model);
  const nlohmann::json document = nlohmann::json::parse(explanation_to_json(found, "mug", "0f"));
  EXPECT_EQ(document["windows"].size(), 3u);
  for (std::size_t window = 0; window < 3; ++window) {
    const nlohmann::json &all = document["windows"][window]["effects"],
                         &border = document["windows"][window]["outline_effects"];
    double sum = 0;
    for (std::size_t angle = 0; angle < 8; ++angle) {
      for (std::size_t ring = 0; ring < 5; ++ring) {
        const auto column = static_cast<Eigen::Index>(80 * window + 5 * angle + ring);
        EXPECT_EQ(all[angle][ring], found.patch.bin_effects[column]);
        EXPECT_EQ(border[angle][ring], found.patch.bin_effects[column + 40]);
        sum += found.patch.bin_effects[column] + found.patch.bin_effects[column + 40];
      }
    }
    EXPECT_NEAR(document["windows"][window]["effect_sum"], sum, 1e-9);
  }
  EXPECT_TRUE(document["nearest_images"].is_null());

  const cv::Mat picture = draw_explanation(found);
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_GT(picture.cols, draw_explanation(explain_grasp(detected(plain), plain.model)).cols);
  GraspExplanation broken = found;
  broken.patch.point_effects.pop_back();
  EXPECT_THROW(draw_explanation(broken), InvalidInput);
  EXPECT_THROW(draw_explanation({}), InvalidInput);
}

TEST(Explanation, FindsThePatchOfTheTrainingImageThatASupportVectorIs) {
  const DescriptorOptions options = few_samples();
  std::vector<LabelledView> views;
  FeatureMatrix rows(0, options.dimension());
  std::vector<std::pair<int, cv::Point2f>> origins;  // of each row: image and centre
  for (int image = 0; image < 3; ++image) {
    const testing::DrawnMug mug = testing::draw_mug({640, 480}, {240 + 20 * image, 200}, 40 + 10 * image);
    views.push_back(
        {"drawn", "mug", image, mug.image, mug.mask, mug.handle, "drawn_" + std::to_string(image)});
    const PatchDescriptors patches = describe_view(foveal_view(mug.image, mug.mask), options);
    const Eigen::Index before = rows.rows();
    rows.conservativeResize(before + patches.features.rows(), Eigen::NoChange);
    rows.bottomRows(patches.features.rows()) = patches.features;
    for (const cv::Point2f& centre : patches.centres_px) origins.emplace_back(image, centre);
  }
  Scene scene = mug_scene(options);
  scene.model = model_of(rows, options);
  const Eigen::Index half = scene.model.coefficients.size() / 2;
  const auto row_of = [&](Eigen::Index vector) {
    return static_cast<std::size_t>(vector < half ? 2 * vector : 2 * (vector - half) + 1);
  };
  scene.model.training_images = {"drawn_0", "drawn_1", "drawn_2"};
  for (Eigen::Index i = 0; i < 2 * half; ++i) scene.model.support_images.push_back(origins[row_of(i)].first);
  ASSERT_NO_THROW(scene.model.check());

  const PatchExplanation found = find_training_patches(explain(scene, 6), scene.model, views);
  for (const std::vector<NearImage>* images : {&found.graspable, &found.not_graspable}) {
    ASSERT_EQ(images->size(), 3u);
    for (const NearImage& image : *images) {
      const auto& [index, centre_px] = origins[row_of(image.support_vector)];
      EXPECT_EQ(image.name, "drawn_" + std::to_string(index));
      ASSERT_TRUE(image.patch);
      EXPECT_EQ(image.patch->centre_px, centre_px);
    }
  }
  views.pop_back();
  EXPECT_THROW(find_training_patches(found, scene.model, views), InvalidInput);
}

}  // namespace
}  // namespace graspctx
