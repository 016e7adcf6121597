// A model that knows which image each support vector comes from: trained, stored, and refused when spoilt.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <random>
#include <string>

#include "graspctx/dataset.hpp"
#include "graspctx/error.hpp"
#include "training_data.hpp"

namespace graspctx {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::fixed_options;
using testing::make_rows;
using testing::Rows;

TrainOptions naming_options(const Rows& rows) {
  TrainOptions options = fixed_options();
  for (const int group : rows.groups) options.image_names[group] = "scene_" + std::to_string(group);
  return options;
}

GraspModel train(const Rows& rows, const TrainOptions& options) {
  GraspModel model = train_model(rows.features, rows.labels, rows.groups, options);
  model.descriptor = testing::tiny_descriptor();
  return model;
}

GraspModel named_model() {
  const Rows rows = make_rows(12, 30, 3, 3);
  return train(rows, naming_options(rows));
}

TEST(TrainingImages, EachSupportVectorIsOfTheImageThatItsRowCameFrom) {
  Rows rows = make_rows(12, 30, 3, 3);
  for (int& group : rows.groups) group = 100 - 7 * group;  // neither sorted nor from zero
  const GraspModel model = train(rows, naming_options(rows));
  ASSERT_EQ(model.support_images.size(), static_cast<std::size_t>(model.coefficients.size()));
  for (Eigen::Index i = 0; i < model.coefficients.size(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    std::size_t nearest = 0;
    for (Eigen::Index row = 0; row < rows.features.rows(); ++row) {
      const double distance =
          ((rows.features.row(row) - model.mean.transpose()).cwiseQuotient(model.scale.transpose()) -
           model.support_vectors.row(i))
              .norm();
      if (distance >= least) continue;
      least = distance;
      nearest = static_cast<std::size_t>(row);
    }
    ASSERT_LT(least, 1e-5);
    const int image = model.support_images[static_cast<std::size_t>(i)];
    EXPECT_EQ(model.training_images[static_cast<std::size_t>(image)],
              "scene_" + std::to_string(rows.groups[nearest]));
    EXPECT_EQ(rows.labels[nearest], model.coefficients[i] > 0);
  }
}

TEST(TrainingImages, NamesChangeNothingElse) {
  const Rows rows = make_rows(12, 30, 3, 3);
  const Bytes without = train(rows, fixed_options()).to_safetensors();
  GraspModel model = train(rows, naming_options(rows));
  EXPECT_GT(model.to_safetensors().size(), without.size());
  model.training_images.clear();
  model.support_images.clear();
  EXPECT_EQ(model.to_safetensors(), without);
}

TEST(TrainingImages, ComeBackFromTheFile) {
  GraspModel model = named_model();
  model.training_images[0] = "Küche/Becher 1.png";
  model.training_images[1] = std::string(255, 'x');
  const Bytes bytes = model.to_safetensors();
  const GraspModel loaded = GraspModel::from_safetensors(bytes.data(), bytes.size());
  EXPECT_EQ(loaded.training_images, model.training_images);
  EXPECT_EQ(loaded.support_images, model.support_images);
  EXPECT_EQ(loaded.to_safetensors(), bytes);
}

TEST(TrainingImages, ModelsWhoseImagesMakeNoSenseAreRefused) {
  const GraspModel good = named_model();
  ASSERT_NO_THROW(good.check());
  const auto refuses = [&](const char* what, const std::function<void(GraspModel&)>& spoil) {
    GraspModel bad = good;
    spoil(bad);
    EXPECT_THROW(bad.check(), InvalidInput) << what;
    EXPECT_THROW(bad.to_safetensors(), InvalidInput) << what;
  };
  refuses("no names", [](GraspModel& m) { m.training_images.clear(); });
  refuses("no images", [](GraspModel& m) { m.support_images.clear(); });
  refuses("an image missing", [](GraspModel& m) { m.support_images.pop_back(); });
  refuses("negative", [](GraspModel& m) { m.support_images[3] = -1; });
  refuses("beyond", [](GraspModel& m) { m.support_images[3] = static_cast<int>(m.training_images.size()); });
  refuses("unused", [](GraspModel& m) { m.training_images.push_back("scene_99"); });
  for (const std::string name :
       {"", "/home/me/scene_1", "C:\\scene_1", "two\nlines", "\x1b[31m", "\x7f", "bad\xff"}) {
    refuses(name.c_str(), [&](GraspModel& m) { m.training_images[0] = name; });
  }
  refuses("too long", [](GraspModel& m) { m.training_images[0] = std::string(256, 'x'); });
}

/// A file as text, with one piece of the header in place of another of the same length.
Bytes edited(const Bytes& bytes, const std::string& from, const std::string& to) {
  std::string text(bytes.begin(), bytes.end());
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  EXPECT_EQ(from.size(), to.size());
  text.replace(at, from.size(), to);
  return {text.begin(), text.end()};
}

TEST(TrainingImages, FilesWithHalfOfThemOrOtherTypesAreRefused) {
  const Bytes bytes = named_model().to_safetensors();
  const auto refusal = [](const Bytes& file) -> std::string {
    try {
      GraspModel::from_safetensors(file.data(), file.size());
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(bytes), "");
  EXPECT_NE(
      refusal(edited(bytes, "\"support_images\"", "\"support_imagez\"")).find("'support_images' is missing"),
      std::string::npos);
  EXPECT_NE(refusal(edited(bytes, "\"training_images\"", "\"training_imagez\""))
                .find("'training_images' is missing"),
            std::string::npos);
  EXPECT_NE(refusal(edited(bytes, "\"I32\"", "\"F32\"")).find("'support_images' as I32"), std::string::npos);
  EXPECT_NE(refusal(edited(bytes, "scene_11\n", "scene_11x")).find("line feed"), std::string::npos);
  EXPECT_NE(refusal(edited(bytes, "scene_0\n", "scene\n_\n")).find("image"), std::string::npos);
}

TEST(TrainingImages, DamagedFilesAreRefusedOrValid) {
  const Bytes bytes = named_model().to_safetensors();
  std::mt19937 random(5);
  int refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Bytes damaged = bytes;
    for (int i = 0; i < 3; ++i) damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random());
    try {
      const GraspModel loaded = GraspModel::from_safetensors(damaged.data(), damaged.size());
      EXPECT_EQ(loaded.to_safetensors().size(), damaged.size());
    } catch (const InvalidInput&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(TrainingImages, TrainingAsksForAUsableNameOfEachImage) {
  const Rows rows = make_rows(12, 30, 3, 3);
  TrainOptions options = naming_options(rows);
  options.image_names.erase(4);
  EXPECT_THROW(train(rows, options), InvalidInput);
  options.image_names[4] = "/tmp/scene_4";
  EXPECT_THROW(train(rows, options), InvalidInput);
  options.image_names[4] = "scene_4";
  EXPECT_NO_THROW(train(rows, options));
}

TEST(TrainingImages, NamesOfViewsFallBackOnTheGroupsNumber) {
  std::vector<LabelledView> views(4);
  const std::string names[] = {"scene_7", "", "/somewhere/scene_8", "bad\xff.png"};
  for (int i = 0; i < 4; ++i) {
    views[static_cast<std::size_t>(i)].group = 10 * i;
    views[static_cast<std::size_t>(i)].image_name = names[i];
  }
  const std::map<int, std::string> expected{
      {0, "scene_7"}, {10, "image 10"}, {20, "image 20"}, {30, "image 30"}};
  EXPECT_EQ(image_names(views), expected);
}

}  // namespace
}  // namespace graspctx
