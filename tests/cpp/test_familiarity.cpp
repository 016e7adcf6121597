// What is familiar to a model, and which of several models answers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "graspctx/error.hpp"
#include "graspctx/familiarity.hpp"
#include "graspctx/model_choice.hpp"
#include "training_data.hpp"

namespace graspctx {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

struct Views {
  FeatureMatrix features;
  std::vector<int> views, groups;
};

/// Patches of objects around one centre, two views of each image.
Views make_views(int images, int patches, int dimension, std::uint32_t seed) {
  std::mt19937 generator(seed);
  Views rows;
  rows.features.resize(images * 2 * patches, dimension);
  for (int view = 0; view < 2 * images; ++view) {
    Eigen::RowVectorXd object(dimension);
    for (double& value : object) value = testing::normal(generator);
    for (int patch = 0; patch < patches; ++patch) {
      const Eigen::Index row = view * patches + patch;
      for (int i = 0; i < dimension; ++i) {
        rows.features(row, i) = static_cast<float>(object[i] + 0.3 * testing::normal(generator));
      }
      rows.views.push_back(view);
      rows.groups.push_back(view / 2);
    }
  }
  return rows;
}

Familiarity learn(const Views& rows, const FamiliarityOptions& options = {}) {
  return learn_familiarity(rows.features, rows.views, rows.groups, options);
}

/// The patches of one view.
FeatureMatrix view_of(const Views& rows, int view, int patches) {
  return rows.features.middleRows(view * patches, patches);
}

FeatureMatrix one_row(std::initializer_list<float> values) {
  FeatureMatrix row(1, static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), row.data());
  return row;
}

/// Training views of three images on a line, at 0 and 0 (the same image), 1 and 3.
Familiarity on_a_line() {
  FeatureMatrix features(4, 1);
  features << 0, 0, 1, 3;
  return learn_familiarity(features, {0, 1, 2, 3}, {0, 0, 1, 2});
}

TEST(Familiarity, ComparesWithTheViewsOfOtherImages) {
  const Familiarity familiarity = on_a_line();
  EXPECT_EQ(familiarity.views.col(0), (Eigen::VectorXf(4) << 0, 0, 1, 3).finished());
  // The two views of one image are as near as can be, and do not count.
  EXPECT_EQ(familiarity.held_out_distances, (Eigen::VectorXd(4) << 1, 1, 1, 2).finished());
  EXPECT_DOUBLE_EQ(familiarity.distance(one_row({2.75f})), 0.25);
  FeatureMatrix patches(2, 1);
  patches << -3, -1;
  EXPECT_DOUBLE_EQ(familiarity.distance(patches), 2);  // their mean
  EXPECT_DOUBLE_EQ(familiarity.at_distance(0.5), 1);
  EXPECT_DOUBLE_EQ(familiarity.at_distance(1), 1);
  EXPECT_DOUBLE_EQ(familiarity.at_distance(1.5), 2.0 / 5);
  EXPECT_DOUBLE_EQ(familiarity.at_distance(2.5), 1.0 / 5);
}

TEST(Familiarity, AShareOfNewObjectsIsAsUnfamiliarAsItSays) {
  const int patches = 5, dimension = 4;
  const Familiarity familiarity = learn(make_views(100, patches, dimension, 1));
  const Views others = make_views(200, patches, dimension, 2);
  for (const double share : {0.05, 0.2, 0.5}) {
    int at_most = 0;
    for (int view = 0; view < 400; ++view) {
      const double distance = familiarity.distance(view_of(others, view, patches));
      at_most += familiarity.at_distance(distance) <= share ? 1 : 0;
    }
    EXPECT_NEAR(at_most / 400.0, share, 0.1) << share;
  }
  FeatureMatrix strange = view_of(others, 0, patches);
  strange.array() += 8;
  EXPECT_DOUBLE_EQ(familiarity.at_distance(familiarity.distance(strange)), 1.0 / 201);
}

TEST(Familiarity, DrawsFromManyViewsTheSameEveryTime) {
  const Views rows = make_views(30, 3, 4, 3);
  FamiliarityOptions few;
  few.max_views = 12;
  const Familiarity drawn = learn(rows, few), all = learn(rows);
  ASSERT_EQ(drawn.views.rows(), 12);
  ASSERT_EQ(all.views.rows(), 60);
  EXPECT_EQ(learn(rows, few).views, drawn.views);
  for (Eigen::Index i = 0; i < drawn.views.rows(); ++i) {
    EXPECT_EQ((all.views.rowwise() - drawn.views.row(i)).rowwise().squaredNorm().minCoeff(), 0);
  }
  EXPECT_GE(drawn.held_out_distances.minCoeff(), all.held_out_distances.minCoeff());
}

TEST(Familiarity, SaysWhatItCannotLearnFrom) {
  FeatureMatrix features = FeatureMatrix::Random(4, 2);
  EXPECT_THROW(learn_familiarity(features, {0, 1, 2}, {0, 1, 2, 3}), InvalidInput);
  EXPECT_THROW(learn_familiarity(features, {0, 0, 1, 1}, {0, 1, 2, 2}),
               InvalidInput);  // a view in two images
  EXPECT_THROW(learn_familiarity(features, {0, 1, 2, 3}, {5, 5, 5, 5}), InvalidInput);
  FamiliarityOptions one;
  one.max_views = 1;
  EXPECT_THROW(learn_familiarity(features, {0, 1, 2, 3}, {0, 1, 2, 3}, one), InvalidInput);
  features(1, 1) = static_cast<float>(not_a_number);
  EXPECT_THROW(learn_familiarity(features, {0, 1, 2, 3}, {0, 1, 2, 3}), InvalidInput);

  const Familiarity familiarity = on_a_line();
  EXPECT_THROW(familiarity.distance(FeatureMatrix(0, 1)), InvalidInput);
  EXPECT_THROW(familiarity.distance(one_row({1, 2})), InvalidInput);
  EXPECT_THROW(familiarity.distance(one_row({static_cast<float>(not_a_number)})), InvalidInput);
}

// ------------------------------------------------------------------------------------------ in a model

/// A model of three columns that has seen objects around one place.
GraspModel model_at(const std::string& name, float place) {
  const testing::Rows rows = testing::make_rows(6, 40, 3, 5);
  GraspModel model = train_model(rows.features, rows.labels, rows.groups, testing::fixed_options());
  model.name = name;
  model.descriptor = testing::tiny_descriptor();
  FeatureMatrix views(4, 3);
  views.setConstant(place);
  views.row(1).array() += 0.1f;
  views.row(2).array() -= 0.1f;
  views.row(3).array() += 0.3f;
  model.familiarity = learn_familiarity(views, {0, 1, 2, 3}, {0, 1, 2, 3});
  return model;
}

GraspModel read(const GraspModel& model) {
  const std::vector<std::uint8_t> bytes = model.to_safetensors();
  return GraspModel::from_safetensors(bytes.data(), bytes.size());
}

TEST(Familiarity, ComesBackFromTheModelsFile) {
  GraspModel model = model_at("mug", 0);
  const GraspModel again = read(model);
  ASSERT_TRUE(again.familiarity);
  EXPECT_EQ(again.familiarity->views, model.familiarity->views);
  EXPECT_EQ(again.familiarity->held_out_distances, model.familiarity->held_out_distances);
  model.familiarity.reset();
  EXPECT_FALSE(read(model).familiarity);
  const std::vector<std::uint8_t> without = model.to_safetensors();
  EXPECT_EQ(std::string(without.begin(), without.end()).find("familiarity"), std::string::npos);
}

TEST(Familiarity, IsCheckedWithItsModel) {
  const GraspModel sound = model_at("mug", 0);
  const auto broken = [&](const auto& breaks) {
    GraspModel model = sound;
    breaks(*model.familiarity);
    EXPECT_THROW(model.check(), InvalidInput);
    EXPECT_THROW(model.to_safetensors(), InvalidInput);
  };
  broken([](Familiarity& f) { f.views.conservativeResize(4, 2); });
  broken([](Familiarity& f) { f.views.conservativeResize(1, 3); });
  broken([](Familiarity& f) { f.views(0, 0) = std::numeric_limits<float>::infinity(); });
  broken([](Familiarity& f) { f.held_out_distances.conservativeResize(3); });
  broken([](Familiarity& f) { f.held_out_distances[3] = not_a_number; });
  broken([](Familiarity& f) { f.held_out_distances[0] = -1; });
  broken([](Familiarity& f) { f.held_out_distances.reverseInPlace(); });

  // A file with one of the two tensors alone.
  std::vector<std::uint8_t> bytes = sound.to_safetensors();
  const std::string name = "familiarity.views", other = "familiarity.viewz";
  const auto at = std::search(bytes.begin(), bytes.end(), name.begin(), name.end());
  ASSERT_NE(at, bytes.end());
  std::copy(other.begin(), other.end(), at);
  EXPECT_THROW(GraspModel::from_safetensors(bytes.data(), bytes.size()), InvalidInput);
}

TEST(ChooseModel, TheNearestOfTheFamiliarAnswers) {
  const GraspModel low = model_at("low", 0), high = model_at("high", 10);
  const std::vector<const GraspModel*> models{&low, &high};
  const auto choose = [&](float place, double min_familiarity) {
    const FeatureMatrix object = FeatureMatrix::Constant(2, 3, place);
    return choose_model(models, {&object, &object}, min_familiarity);
  };
  EXPECT_EQ(choose(0.02f, 0.5).model, 0u);
  EXPECT_EQ(choose(9.98f, 0.5).model, 1u);
  EXPECT_TRUE(choose(9.98f, 0.5).familiar);
  const ModelChoice unfamiliar = choose(6, 0.5);
  EXPECT_EQ(unfamiliar.model, 1u);
  EXPECT_FALSE(unfamiliar.familiar);
  EXPECT_DOUBLE_EQ(unfamiliar.familiarity, 1.0 / 5);
  EXPECT_TRUE(choose(6, 0).familiar);
}

TEST(ChooseModel, AFamiliarOneGoesBeforeANearerOne) {
  GraspModel near = model_at("near", 0), wide = model_at("wide", 10);
  wide.familiarity->held_out_distances.setConstant(20);  // its objects differ that much from each other
  const FeatureMatrix object = FeatureMatrix::Constant(1, 3, 3);
  EXPECT_EQ(choose_model({&near, &wide}, {&object, &object}, 0.5).model, 1u);
  EXPECT_EQ(choose_model({&near, &wide}, {&object, &object}, 0).model, 0u);
}

TEST(ChooseModel, RefusesModelsThatCannotTell) {
  GraspModel model = model_at("mug", 0);
  const FeatureMatrix object = FeatureMatrix::Zero(1, 3);
  EXPECT_THROW(choose_model({}, {}, 0), InvalidInput);
  EXPECT_THROW(choose_model({&model}, {}, 0), InvalidInput);
  EXPECT_THROW(choose_model({&model}, {&object}, 1.5), InvalidInput);
  EXPECT_THROW(choose_model({&model}, {&object}, not_a_number), InvalidInput);
  model.familiarity.reset();
  EXPECT_THROW(choose_model({&model}, {&object}, 0), InvalidInput);
}

}  // namespace
}  // namespace graspctx
