// What is written for others to read: JSON and .npy.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <locale>
#include <nlohmann/json.hpp>

#include "graspctx/io/detection_json.hpp"
#include "graspctx/io/npy.hpp"
#include "graspctx/io/segmentation_json.hpp"
#include "graspctx/version.hpp"
#include "temporary_folder.hpp"

namespace graspctx {
namespace {

using nlohmann::json;
using testing::TemporaryFolder;

Detection made_up_detection() {
  Detection detection;
  detection.image_size = {640, 480};
  detection.segmentation.table = TablePlane{0.1, 0.2, 3, {0, -0.6, -0.8}, 0.7, 0.1};
  detection.timings_ms = {{"rectify", 0.5}, {"disparity", 12.25}};
  DetectedObject object;
  object.id = 3;
  object.bounding_box_px = {10, 20, 30, 40};
  object.centroid_px = {25.5, 1.0 / 3};
  object.pose.emplace();
  object.pose->centroid_m = {0, 0.1, 0.7};
  object.pose->source = ObjectPose::Source::segment_depth;
  GraspConfiguration grasp;
  grasp.rank = 1;
  grasp.probability = 0.1 + 0.2;  // not exactly 0.3: must survive
  grasp.left_px = {300.25, 200};
  grasp.rule = ApproachRule::minor_axis;
  grasp.cam_from_hand << 0, 0, 1, 4, 1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 0, 1;
  grasp.opening_m = 0.07;
  object.grasps.push_back(grasp);
  grasp.rank = 2;
  grasp.feasible = false;
  grasp.infeasible_because = "the palm would come through the table";
  object.grasps.push_back(grasp);
  detection.objects.push_back(object);
  detection.objects.push_back({});
  return detection;
}

TEST(DetectionJson, FollowsTheSchema) {
  const json document = json::parse(detection_to_json(made_up_detection(), "mug", "abc"));
  EXPECT_EQ(document["schema"], 1);
  EXPECT_EQ(document["graspctx"], version);
  EXPECT_EQ(document["frame"], "left_rectified_optical");
  EXPECT_EQ(document["image_size"], (json{640, 480}));
  EXPECT_EQ(document["model"], (json{{"name", "mug"}, {"sha256", "abc"}}));
  EXPECT_EQ(document["table_plane"]["normal"], (json{0, -0.6, -0.8}));
  EXPECT_EQ(document["timings_ms"]["disparity"], 12.25);
  ASSERT_EQ(document["objects"].size(), 2u);
  const json& object = document["objects"][0];
  EXPECT_EQ(object["bounding_box_px"], (json{10, 20, 30, 40}));
  EXPECT_EQ(object["centroid_px"][1].get<double>(), 1.0 / 3);
  EXPECT_EQ(object["pose"]["source"], "segment_depth");
  EXPECT_EQ(document["objects"][1]["pose"], nullptr);
  EXPECT_EQ(document["objects"][1]["grasps"], json::array());
  const json& grasp = object["grasps"][0];
  EXPECT_EQ(grasp["probability"].get<double>(), 0.1 + 0.2);
  EXPECT_EQ(grasp["rule"], "minor_axis");
  EXPECT_EQ(grasp["cam_from_hand"][1], (json{1, 0, 0, 5}));  // rows
  EXPECT_EQ(grasp["infeasible_because"], nullptr);
  EXPECT_EQ(object["grasps"][1]["infeasible_because"], "the palm would come through the table");
  const std::vector<std::string> keys{"rank",      "probability", "probability_left",  "probability_right",
                                      "left_px",   "right_px",    "position_m",        "position_stddev_m",
                                      "rule",      "approach",    "closing",           "cam_from_hand",
                                      "opening_m", "feasible",    "infeasible_because"};
  EXPECT_EQ(grasp.size(), keys.size());
  for (const std::string& key : keys) EXPECT_TRUE(grasp.contains(key)) << key;
}

TEST(DetectionJson, SaysWhichModelAnswered) {
  Detection detection = made_up_detection();
  detection.objects[0].model_name = "mug";
  detection.objects[0].familiarity = 0.25;
  const json objects = json::parse(detection_to_json(detection, "mug,pencil", "abc,def"))["objects"];
  EXPECT_EQ(objects[0]["model"], "mug");
  EXPECT_EQ(objects[0]["familiarity"], 0.25);
  EXPECT_EQ(objects[0]["unfamiliar"], false);
  for (const char* key : {"model", "familiarity", "unfamiliar"}) EXPECT_FALSE(objects[1].contains(key));
}

TEST(DetectionJson, NothingFoundIsAnAnswer) {
  Detection detection;
  detection.image_size = {640, 480};
  const json document = json::parse(detection_to_json(detection, "mug", ""));
  EXPECT_EQ(document["objects"], json::array());
  EXPECT_EQ(document["table_plane"], nullptr);
  EXPECT_EQ(document["timings_ms"], json::object());
}

TEST(DetectionJson, DoesNotDependOnTheLocale) {
  struct CommaPoint : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::string text = detection_to_json(made_up_detection(), "mug", "abc");
  const std::locale before = std::locale::global(std::locale(std::locale(), new CommaPoint));
  const std::string with_comma = detection_to_json(made_up_detection(), "mug", "abc");
  std::locale::global(before);
  EXPECT_EQ(text, with_comma);
}

TEST(DetectionJson, RefusesNumbersThatJsonCannotHold) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    Detection detection = made_up_detection();
    detection.objects[0].grasps[1].position_m.z() = bad;
    EXPECT_THROW(detection_to_json(detection, "mug", "abc"), std::logic_error);
  }
}

Segmentation made_up_segmentation() {
  Segmentation segmentation;
  segmentation.instance_ids = cv::Mat::zeros(480, 640, CV_8UC1);
  segmentation.table = TablePlane{0.1, 0.2, 3, {0, -0.6, -0.8}, 0.7, 0.1};
  segmentation.vertical_offset_px = 2.5;
  segmentation.warnings = {"the views are 2.5 px apart"};
  ObjectHypothesis object;
  object.id = 1;
  object.bounding_box_px = {10, 20, 30, 40};
  object.centroid_px = {25.5, 1.0 / 3};
  object.saliency = 54.25;
  object.leaves_table = true;
  object.size_m = Eigen::Vector3d(0.1, 0.05, 0.1 + 0.2);
  object.depth_m = 0.75;
  segmentation.objects = {object, {}};
  return segmentation;
}

TEST(SegmentationJson, FollowsTheSchema) {
  const std::string text =
      segmentation_to_json(made_up_segmentation(), CueLevel::plane, {{"disparity", 12.25}, {"a", 1}});
  const json document = json::parse(text);
  const auto ordered = nlohmann::ordered_json::parse(text);
  const auto keys = [](const auto& object) {
    std::string names;
    for (const auto& [name, value] : object.items()) names += name + " ";
    return names;
  };
  EXPECT_EQ(
      keys(ordered),
      "schema graspctx frame image_size cues table_plane objects vertical_offset_px warnings timings_ms ");
  EXPECT_EQ(keys(ordered["objects"][0]),
            "id bounding_box_px centroid_px saliency touches_border leaves_table size_m depth_m ");
  EXPECT_EQ(keys(ordered["timings_ms"]), "disparity a ");
  EXPECT_EQ(document["schema"], 1);
  EXPECT_EQ(document["image_size"], (json{640, 480}));
  EXPECT_EQ(document["cues"], "plane");
  EXPECT_EQ(document["table_plane"]["offset_m"], 0.7);
  EXPECT_EQ(document["vertical_offset_px"], 2.5);
  EXPECT_EQ(document["warnings"], (json{"the views are 2.5 px apart"}));
  const json& object = document["objects"][0];
  EXPECT_EQ(object["centroid_px"][1].get<double>(), 1.0 / 3);
  EXPECT_EQ(object["size_m"][2].get<double>(), 0.1 + 0.2);
  EXPECT_EQ(object["leaves_table"], true);
  EXPECT_EQ(object["touches_border"], false);
  EXPECT_EQ(document["objects"][1]["size_m"], nullptr);
  EXPECT_EQ(document["objects"][1]["depth_m"], nullptr);
  EXPECT_EQ(segmentation_to_json(made_up_segmentation(), CueLevel::plane, {}, -1).find('\n'),
            segmentation_to_json(made_up_segmentation(), CueLevel::plane, {}, -1).size() - 1);
}

TEST(SegmentationJson, NothingFoundIsAnAnswerAndWhatIsNotFiniteIsNone) {
  Segmentation nothing;
  nothing.instance_ids = cv::Mat::zeros(3, 4, CV_8UC1);
  const json document = json::parse(segmentation_to_json(nothing, CueLevel::colour));
  EXPECT_EQ(document["objects"], json::array());
  EXPECT_EQ(document["table_plane"], nullptr);
  EXPECT_EQ(document["vertical_offset_px"], nullptr);
  EXPECT_EQ(document["warnings"], json::array());
  Segmentation bad = made_up_segmentation();
  bad.objects[1].depth_m = std::nan("");
  EXPECT_THROW(segmentation_to_json(bad, CueLevel::colour), std::logic_error);
}

TEST(Npy, HeaderAndDataAreWhereTheFormatPutsThem) {
  const TemporaryFolder folder;
  FeatureMatrix matrix(3, 2);
  matrix << 1, 2.5, -3, 4, 1e-20f, 6;
  for (const Eigen::Index rows : {Eigen::Index{3}, Eigen::Index{0}}) {
    write_npy(folder / "matrix.npy", matrix.topRows(rows));
    const std::string bytes = folder.get("matrix.npy");
    ASSERT_GE(bytes.size(), 64u);
    EXPECT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
    const std::size_t header_size =
        static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
    EXPECT_EQ((10 + header_size) % 64, 0u);
    const std::string header = bytes.substr(10, header_size);
    EXPECT_NE(header.find("'shape': (" + std::to_string(rows) + ", 2)"), std::string::npos) << header;
    EXPECT_EQ(header.back(), '\n');
    ASSERT_EQ(bytes.size(), 10 + header_size + 8 * static_cast<std::size_t>(rows));
    EXPECT_EQ(std::memcmp(bytes.data() + 10 + header_size, matrix.data(), 8 * static_cast<std::size_t>(rows)),
              0);
  }
}

}  // namespace
}  // namespace graspctx
