#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "graspctx/error.hpp"
#include "graspctx/io/dataset_files.hpp"
#include "graspctx/io/image_file.hpp"
#include "synthetic.hpp"
#include "temporary_folder.hpp"

namespace graspctx {
namespace {

using testing::message_of;
using testing::TemporaryFolder;
namespace fs = std::filesystem;

const cv::Size image_size(64, 48);
const cv::Rect mug_box(10, 12, 20, 16), pencil_box(40, 5, 4, 30), label_box(20, 10, 30, 10);

/// A 16-bit grey PNG of 64x48 zeros, made once by an independent encoder (Pillow).
std::string depth_png() {
  static const unsigned char bytes[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
      0x00, 0x00, 0x40, 0x00, 0x00, 0x00, 0x30, 0x10, 0x00, 0x00, 0x00, 0x00, 0xd4, 0xb0, 0xff, 0x80, 0x00,
      0x00, 0x00, 0x1c, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0xed, 0xc1, 0x01, 0x01, 0x00, 0x00, 0x00, 0x82,
      0x20, 0xff, 0xaf, 0x6e, 0x48, 0x40, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0xef, 0x06, 0x18, 0x30, 0x00,
      0x01, 0xf4, 0xf6, 0x92, 0xb5, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  return {reinterpret_cast<const char*>(bytes), sizeof bytes};
}

DatasetOptions of_classes(std::vector<std::string> classes) {
  DatasetOptions options;
  options.classes = std::move(classes);
  return options;
}

/// Two scenes of a mug (id 1) and a pencil (id 7), which the right view of the second does not see.
void make_dataset(const TemporaryFolder& folder) {
  folder.put("dataset.json", R"({"format": "graspctx-dataset", "version": 1})");
  for (const std::string scene : {"scene_000000", "scene_000001"}) {
    folder.put(
        scene + "/scene.json",
        R"({"schema": 1, "objects": [{"id": 1, "family": "mug"}, {"id": 7, "family": "pencil", "extra": 3}]})");
    folder.put(scene + "/calib.txt",
               "cam0=[60 0 32; 0 60 24; 0 0 1]\ncam1=[60 0 32; 0 60 24; 0 0 1]\n"
               "doffs=0\nbaseline=80\nwidth=64\nheight=48\n");
    folder.put(scene + "/left_depth.png", depth_png());
    for (const std::string side : {"left", "right"}) {
      cv::Mat ids = cv::Mat::zeros(image_size, CV_8UC1), label = ids.clone();
      ids(mug_box) = 1;
      if (!(scene == "scene_000001" && side == "right")) ids(pencil_box) = 7;
      label(label_box) = 255;
      label.setTo(0, ids == 0);
      const fs::path start = folder / (scene + "/" + side);
      write_image(start.string() + ".png", testing::random_texture(image_size, 3));
      write_image(start.string() + "_mask.png", ids);
      write_image(start.string() + "_label.png", label);
    }
  }
}

TEST(DatasetFiles, GivesOneViewForEachVisibleObject) {
  const TemporaryFolder folder;
  make_dataset(folder);
  const std::vector<LabelledView> views = load_dataset(folder.path());
  ASSERT_EQ(views.size(), 7u);  // 2 scenes × 2 views × 2 objects, one pencil out of sight
  EXPECT_EQ(std::count_if(views.begin(), views.end(), [](const auto& v) { return v.class_name == "pencil"; }),
            3);
  for (const LabelledView& view : views) {
    const cv::Rect box = view.class_name == "mug" ? mug_box : pencil_box;
    EXPECT_EQ(cv::countNonZero(view.mask), box.area());
    EXPECT_EQ(cv::boundingRect(view.mask), box);
    EXPECT_EQ(cv::boundingRect(view.label), box & label_box);  // the other object's label is not this one's
  }
  EXPECT_EQ(views.front().group, 0);
  EXPECT_EQ(views.back().group, 1);
  EXPECT_TRUE(check_dataset(folder.path()).problems.empty());
}

TEST(DatasetFiles, KeepsToTheClassesAndViewsAskedFor) {
  const TemporaryFolder folder;
  make_dataset(folder);
  EXPECT_EQ(load_dataset(folder.path(), of_classes({"pencil"})).size(), 3u);
  DatasetOptions left_pencils = of_classes({"pencil"});
  left_pencils.views = DatasetViews::left;
  EXPECT_EQ(load_dataset(folder.path(), left_pencils).size(), 2u);
  const std::string message =
      message_of<InvalidInput>([&] { load_dataset(folder.path(), of_classes({"teapot"})); });
  EXPECT_NE(message.find("mug, pencil"), std::string::npos) << message;
}

DatasetOptions of_images(std::vector<std::string> images) {
  DatasetOptions options;
  options.images = std::move(images);
  return options;
}

TEST(DatasetFiles, ImagesAreNamedWithinTheDataSetAndTakenByName) {
  const TemporaryFolder folder;
  make_dataset(folder);
  for (const LabelledView& view : load_dataset(folder.path())) {
    EXPECT_EQ(view.image_name, "scene_00000" + std::to_string(view.group));
  }
  write_image(folder / "scene_000000/left_mask.png", cv::Mat::zeros(1, 1, CV_8UC1));  // is not even looked at
  const std::vector<LabelledView> views = load_dataset(folder.path(), of_images({"scene_000001", "scene_9"}));
  EXPECT_EQ(views.size(), 3u);
  EXPECT_EQ(views.front().group, 1);
  const std::string message =
      message_of<InvalidInput>([&] { load_dataset(folder.path(), of_images({"scene_9"})); });
  EXPECT_NE(message.find("none of the images asked for, expected scene_9"), std::string::npos) << message;
}

TEST(DatasetFiles, IgnoresAScenesStillBeingWritten) {
  const TemporaryFolder folder;
  make_dataset(folder);
  folder.put("scene_000002.partial/scene.json", "{}");
  EXPECT_EQ(load_dataset(folder.path()).size(), 7u);
}

TEST(DatasetFiles, NamesTheFileThatIsBroken) {
  struct Damage {
    std::string file, content;  // empty content: removed
  };
  const std::vector<Damage> damages{
      {"dataset.json", ""},
      {"dataset.json", "{"},
      {"dataset.json", "[1, 2]"},
      {"dataset.json", R"({"format": "other", "version": 1})"},
      {"dataset.json", R"({"format": "graspctx-dataset", "version": 99})"},
      {"scene_000001/scene.json", R"({"schema": 1, "objects": [)"},
      {"scene_000001/scene.json", R"({"schema": 1, "objects": 5})"},
      {"scene_000001/scene.json", R"({"schema": 1, "objects": [5]})"},
      {"scene_000001/scene.json", R"({"schema": 2, "objects": [{"id": 1, "family": "mug"}]})"},
      {"scene_000001/scene.json", R"({"schema": 1, "objects": [{"id": 1, "family": "mug"}], })"},
      {"scene_000001/scene.json", R"({"schema": 1, "objects": [{"id": 0, "family": "mug"}]})"},
      {"scene_000001/scene.json", R"({"schema": 1, "objects": [{"id": 1e30, "family": "mug"}]})"},
      {"scene_000001/scene.json", R"({"schema": 1, "objects": [{"id": 99999999999, "family": "mug"}]})"},
      {"scene_000001/scene.json", R"({"schema": 1, "objects": [{"id": 1, "family": 4}]})"},
      {"scene_000001/scene.json",
       R"({"schema": 1, "objects": [{"id": 1, "family": "a"}, {"id": 1, "family": "b"}]})"},
      {"scene_000001/scene.json", std::string(200000, '[')},
      {"scene_000001/left.png", ""},
      {"scene_000001/right.png", "no picture"},
      {"scene_000001/left_mask.png", ""},
      {"scene_000001/right_label.png", ""},
      {"scene_000001/right_label.png", depth_png()},
  };
  for (const Damage& damage : damages) {
    const TemporaryFolder folder;
    make_dataset(folder);
    if (damage.content.empty()) {
      fs::remove(folder / damage.file);
    } else {
      folder.put(damage.file, damage.content);
    }
    const std::string message = message_of<InvalidInput>([&] { load_dataset(folder.path()); });
    EXPECT_NE(message.find((folder / damage.file).string()), std::string::npos)
        << damage.file << " " << damage.content.substr(0, 40) << ": " << message;
    const std::vector<std::string> problems = check_dataset(folder.path()).problems;
    ASSERT_FALSE(problems.empty()) << damage.file;
    EXPECT_TRUE(std::any_of(problems.begin(), problems.end(), [&](const std::string& problem) {
      return problem.find((folder / damage.file).string()) != std::string::npos;
    })) << problems.front();
  }
}

TEST(DatasetFiles, RefusesLabelsOfAnotherSize) {
  const TemporaryFolder folder;
  make_dataset(folder);
  write_image(folder / "scene_000000/left_label.png", cv::Mat::zeros(10, 10, CV_8UC1));
  const std::string message = message_of<InvalidInput>([&] { load_dataset(folder.path()); });
  EXPECT_NE(message.find("left_label.png"), std::string::npos) << message;
}

TEST(DatasetFiles, RefusesAFolderWithoutScenes) {
  const TemporaryFolder folder;
  EXPECT_THROW(load_dataset(folder.path()), InvalidInput);
  folder.put("dataset.json", R"({"format": "graspctx-dataset", "version": 1})");
  EXPECT_THROW(load_dataset(folder.path()), InvalidInput);
  EXPECT_THROW(load_dataset(folder / "missing"), InvalidInput);
  EXPECT_THROW(load_dataset(folder / "dataset.json"), InvalidInput);
  EXPECT_EQ(check_dataset(folder.path()).problem_count, 1u);
}

TEST(DatasetFiles, CheckFindsEveryProblemAtOnce) {
  const TemporaryFolder folder;
  make_dataset(folder);
  fs::remove(folder / "scene_000000/left_depth.png");
  write_image(folder / "scene_000000/right_mask.png",
              cv::Mat(image_size, CV_8UC1, cv::Scalar(9)));  // unknown id
  write_image(folder / "scene_000001/left_label.png", cv::Mat(image_size, CV_8UC1, cv::Scalar(100)));
  folder.put("scene_000001/calib.txt", "no calibration");
  const std::vector<std::string> problems = check_dataset(folder.path()).problems;
  for (const std::string part : {"scene_000000/left_depth.png", "scene_000000/right_mask.png",
                                 "scene_000001/left_label.png", "scene_000001/calib.txt"}) {
    EXPECT_TRUE(std::any_of(problems.begin(), problems.end(), [&](const std::string& problem) {
      return problem.find(part) != std::string::npos;
    })) << part;
  }
  EXPECT_EQ(problems.size(), 5u);  // the label is neither binary nor on the objects alone
}

TEST(DatasetFiles, CheckCountsThePixels) {
  const TemporaryFolder folder;
  make_dataset(folder);
  const std::string counts =
      R"("visible_px": {"left": 320, "right": 320}, "label_px": {"left": 101, "right": 80})";
  ASSERT_EQ(mug_box.area(), 320);
  ASSERT_EQ((mug_box & label_box).area(), 80);
  folder.put("scene_000000/scene.json", R"({"schema": 1, "objects": [{"id": 1, "family": "mug", )" + counts +
                                            R"(}, {"id": 7, "family": "pencil"}]})");
  const std::vector<std::string> problems = check_dataset(folder.path()).problems;
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].find("left_label.png"), std::string::npos) << problems[0];
  EXPECT_NE(problems[0].find("101"), std::string::npos) << problems[0];
}

TEST(DatasetFiles, ReadsSaxenasLayout) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "img");
  fs::create_directories(folder / "grasp");
  for (const std::string name : {"0001", "0002"}) {
    const testing::DrawnMug mug = testing::draw_mug({320, 240}, {150, 110}, 40);
    write_image(folder / ("img/" + name + ".png"), mug.image);
    cv::Mat label = cv::Mat::zeros(mug.image.size(), CV_8UC3);
    label.setTo(cv::Scalar(0, 0, 7), mug.handle);  // any pixel that is not black
    write_image(folder / ("grasp/graspPriorityWidth_" + name + ".png"), label);
  }
  const testing::DrawnMug truth = testing::draw_mug({320, 240}, {150, 110}, 40);
  const std::vector<LabelledView> views = load_dataset(folder.path());
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(views[0].class_name, "object");
  EXPECT_NE(views[0].group, views[1].group);
  // Corners are rounded a little.
  EXPECT_LE(cv::countNonZero(views[0].mask != truth.mask), 0.005 * cv::countNonZero(truth.mask));
  EXPECT_LE(cv::countNonZero(views[0].label != truth.handle), 0.02 * cv::countNonZero(truth.handle));
  EXPECT_TRUE(check_dataset(folder.path()).problems.empty());
  EXPECT_EQ(views[0].image_name, "0001.png");
  EXPECT_EQ(load_dataset(folder.path(), of_images({"0002.png"})).size(), 1u);
  EXPECT_THROW(load_dataset(folder.path(), of_images({"0003.png"})), InvalidInput);

  fs::remove(folder / "grasp/graspPriorityWidth_0002.png");
  const std::string message = message_of<InvalidInput>([&] { load_dataset(folder.path()); });
  EXPECT_NE(message.find("graspPriorityWidth_0002.png"), std::string::npos) << message;
  EXPECT_THROW(load_dataset(folder.path(), of_classes({"mug"})), InvalidInput);
}

}  // namespace
}  // namespace graspctx
