#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "graspctx/error.hpp"
#include "graspctx/io/dataset_files.hpp"
#include "graspctx/io/image_file.hpp"
#include "synthetic.hpp"
#include "temporary_folder.hpp"

// Data sets as annotation tools write them: labelme and COCO.

namespace graspctx {
namespace {

using testing::message_of;
using testing::TemporaryFolder;
namespace fs = std::filesystem;
using Json = nlohmann::json;

const cv::Size image_size(64, 48);

DatasetOptions labels(std::vector<std::string> objects = {"mug"},
                      std::vector<std::string> grasps = {"handle"}) {
  DatasetOptions options;
  options.object_labels = std::move(objects);
  options.grasp_labels = std::move(grasps);
  return options;
}

Json rectangle(double left, double top, double right, double bottom) {
  return {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
}

Json shape(const std::string& label, const Json& points, const std::string& type = "polygon") {
  return {{"label", label}, {"points", points}, {"shape_type", type}, {"group_id", nullptr}};
}

Json labelme(const Json& shapes, const std::string& image = "photo.png") {
  return {{"version", "5.0"},
          {"flags", Json::object()},
          {"shapes", shapes},
          {"imagePath", image},
          {"imageData", nullptr},
          {"imageHeight", image_size.height},
          {"imageWidth", image_size.width}};
}

/// A folder with one photograph and what labelme says of it.
struct LabelmeFolder : TemporaryFolder {
  explicit LabelmeFolder(const Json& json) {
    write_image(*this / "photo.png", testing::random_texture(image_size, 1));
    put("photo.json", json.dump());
  }
  explicit LabelmeFolder(const Json::initializer_list_t& shapes)
      : LabelmeFolder(labelme(Json::array(shapes))) {}
  std::vector<LabelledView> load(const DatasetOptions& options = labels()) const {
    return load_dataset(path(), options);
  }
  std::string refusal(const DatasetOptions& options = labels()) const {
    return message_of<InvalidInput>([&] { load(options); });
  }
};

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// ---- outlines ----

TEST(Annotations, RectanglesCoverTheirPixels) {
  const LabelmeFolder folder{shape("mug", rectangle(10, 5, 40, 35)),
                             shape("handle", Json{{30, 10}, {36.4, 14.6}}, "rectangle")};
  const std::vector<LabelledView> views = folder.load();
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(views[0].class_name, "mug");
  EXPECT_EQ(views[0].image.size(), image_size);
  EXPECT_EQ(cv::boundingRect(views[0].mask), cv::Rect(10, 5, 30, 30));  // whole pixels
  EXPECT_EQ(cv::countNonZero(views[0].mask), 900);
  // From 30 to 36.4 there are the centres 30.5 … 35.5, from 10 to 14.6 there are 10.5 … 14.5.
  EXPECT_EQ(cv::boundingRect(views[0].label), cv::Rect(30, 10, 6, 5));
  EXPECT_EQ(cv::countNonZero(views[0].label), 30);
}

/// Whether a point lies inside, by its winding: another rule and another formula than the reader's.
bool winds_around(const std::vector<cv::Point2d>& polygon, const cv::Point2d& p) {
  double turned = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const cv::Point2d a = polygon[i] - p, b = polygon[(i + 1) % polygon.size()] - p;
    turned += std::atan2(a.cross(b), a.dot(b));
  }
  return std::abs(turned) > CV_PI;
}

TEST(Annotations, PolygonsCoverThePixelsWhoseCentresTheyHold) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    std::mt19937 generator(seed);
    // A star around a point: never crosses itself, mostly concave, and sometimes leaves the image.
    std::vector<cv::Point2d> polygon;
    Json points = Json::array();
    const int corners = 3 + static_cast<int>(generator() % 12);
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * CV_PI * i / corners, radius = testing::uniform(generator, 4, 40);
      polygon.emplace_back(32 + radius * std::cos(angle), 24 + radius * std::sin(angle));
      points.push_back({polygon.back().x, polygon.back().y});
    }
    const LabelmeFolder folder{shape("mug", points), shape("handle", points)};
    const std::vector<LabelledView> views = folder.load();
    ASSERT_EQ(views.size(), 1u);
    int different = 0;
    for (int v = 0; v < image_size.height; ++v) {
      for (int u = 0; u < image_size.width; ++u) {
        const bool inside = winds_around(polygon, {u + 0.5, v + 0.5});
        different += inside != (views[0].mask.at<uchar>(v, u) == 255);
      }
    }
    EXPECT_EQ(different, 0) << "seed " << seed;
  }
}

TEST(Annotations, CirclesHaveTheirArea) {
  const LabelmeFolder folder{shape("mug", Json{{32, 24}, {32, 44}}, "circle"),
                             shape("handle", Json{{32, 24}, {37, 24}}, "circle")};
  const std::vector<LabelledView> views = folder.load();
  EXPECT_NEAR(cv::countNonZero(views[0].mask), CV_PI * 20 * 20, 15);
  EXPECT_NEAR(cv::countNonZero(views[0].label), CV_PI * 5 * 5, 6);
}

TEST(Annotations, PolygonsAreCutAtTheImage) {
  const LabelmeFolder folder{shape("mug", rectangle(-1e6, 10, 20, 1e6)),
                             shape("handle", rectangle(0, 10, 5, 15))};
  EXPECT_EQ(cv::boundingRect(folder.load()[0].mask), cv::Rect(0, 10, 20, 38));
}

// ---- objects and grasp regions ----

TEST(Annotations, AGraspRegionBelongsToTheObjectThatHoldsMostOfIt) {
  const LabelmeFolder folder{
      shape("handle", rectangle(25, 10, 35, 20)),  // 4 columns on the first mug, 6 on the second
      shape("mug", rectangle(5, 5, 29, 40)), shape("mug", rectangle(29, 5, 60, 40)),
      shape("handle", rectangle(6, 6, 9, 9))};
  const std::vector<LabelledView> views = folder.load();
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(cv::boundingRect(views[0].label), cv::Rect(6, 6, 3, 3));
  EXPECT_EQ(cv::boundingRect(views[1].label), cv::Rect(29, 10, 6, 10));  // cut at the object
  EXPECT_EQ(views[0].group, views[1].group);
}

TEST(Annotations, RegionsOfObjectsThatAreNotAskedForAreLeftAlone) {
  const LabelmeFolder folder{shape("mug", rectangle(5, 5, 30, 40)), shape("handle", rectangle(6, 6, 9, 9)),
                             shape("pan", rectangle(35, 5, 60, 40)), shape("handle", rectangle(50, 6, 60, 9)),
                             shape("note", Json{{1, 1}}, "point")};
  const std::vector<LabelledView> views = folder.load();
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(cv::boundingRect(views[0].label), cv::Rect(6, 6, 3, 3));
  EXPECT_EQ(folder.load(labels({"mug", "pan"})).size(), 2u);
  DatasetOptions pans = labels({"mug", "pan"});
  pans.classes = {"pan"};
  ASSERT_EQ(folder.load(pans).size(), 1u);
  EXPECT_EQ(folder.load(pans)[0].class_name, "pan");
}

TEST(Annotations, AGraspRegionBesideItsObjectIsAMistake) {
  const LabelmeFolder folder{shape("mug", rectangle(5, 5, 30, 40)),
                             shape("handle", rectangle(28, 10, 38, 20))};
  EXPECT_TRUE(holds(folder.refusal(), "photo.json: less than half of shape 2 ('handle')"))
      << folder.refusal();
}

TEST(Annotations, PartsOfOneGroupAreOneObject) {
  Json left = shape("mug", rectangle(5, 5, 20, 20)), right = shape("mug", rectangle(30, 5, 40, 20));
  left["group_id"] = right["group_id"] = 4;
  const LabelmeFolder folder{left, right, shape("handle", rectangle(31, 6, 35, 9))};
  const std::vector<LabelledView> views = folder.load();
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(cv::countNonZero(views[0].mask), 15 * 15 + 10 * 15);
}

TEST(Annotations, ImagesAreGroups) {
  const LabelmeFolder folder{shape("mug", rectangle(5, 5, 30, 40)), shape("handle", rectangle(6, 6, 9, 9))};
  folder.put("another.json", folder.get("photo.json"));
  folder.put("empty.json", labelme(Json::array()).dump());
  const std::vector<LabelledView> views = folder.load();
  ASSERT_EQ(views.size(), 2u);
  EXPECT_NE(views[0].group, views[1].group);
  EXPECT_EQ(views[0].image_name, "photo.png");
  DatasetOptions options = labels();
  options.images = {"photo.png"};
  EXPECT_EQ(folder.load(options).size(), 2u);
  options.images = {"other.png"};
  EXPECT_TRUE(holds(folder.refusal(options), "expected other.png"));
}

TEST(Annotations, LabelsMustBeGivenAndBeThere) {
  const LabelmeFolder folder{shape("mug", rectangle(5, 5, 30, 40)), shape("handle", rectangle(6, 6, 9, 9))};
  EXPECT_TRUE(holds(folder.refusal({}), "its labels are: handle, mug")) << folder.refusal({});
  EXPECT_TRUE(holds(folder.refusal(labels({"mug"}, {})), "--grasp-label"));
  EXPECT_TRUE(holds(folder.refusal(labels({"mugg"})), "'mugg', its labels are: handle, mug"));
  EXPECT_TRUE(holds(folder.refusal(labels({"mug"}, {"grip"})), "'grip'"));
  const DatasetReport report = check_dataset(folder.path());  // shows them
  EXPECT_TRUE(report.problems.empty());
  EXPECT_EQ(report.summary.labels, (std::map<std::string, int>{{"handle", 1}, {"mug", 1}}));
}

// ---- broken labelme files ----

TEST(Annotations, LabelmeFilesThatAreBrokenAreNamed) {
  const Json mug = shape("mug", rectangle(5, 5, 30, 40)), handle = shape("handle", rectangle(6, 6, 9, 9));
  const auto with = [&](const Json& third) { return labelme(Json::array({mug, handle, third})); };
  const auto edited = [&](const std::string& key, const Json& value) {
    Json json = labelme(Json::array({mug, handle}));
    json[key] = value;
    return json;
  };
  struct Broken {
    Json json;
    std::string said;
  };
  const std::vector<Broken> cases{
      {edited("imagePath", "../photo.png"), "expected a relative path inside of"},
      {edited("imagePath", "a/../../photo.png"), "expected a relative path inside of"},
      {edited("imagePath", "..\\photo.png"), "expected a relative path inside of"},
      {edited("imagePath", "/etc/passwd"), "expected a relative path inside of"},
      {edited("imagePath", "C:\\photo.png"), "expected a relative path inside of"},
      {edited("imagePath", ""), "expected a relative path inside of"},
      {edited("imagePath", 7), "'imagePath' is missing"},
      {edited("imagePath", "other.png"), "other.png: no such file"},
      {edited("imageWidth", 65), "photo.png: is 64x48 px, expected 65x48"},
      {with(shape("mug", rectangle(100, 5, 130, 40))), "shape 3 ('mug') covers no pixel"},
      {with(shape("mug", Json{{1, 1}, {9, 9}})), "shape 3 ('mug')"},
      {with(shape("mug", Json{{1, 1}, {9, 9}}, "line")), "\"line\" of 2 points outlines no region"},
      {with(shape("mug", rectangle(0, 0, 1e7, 10))), "within 1000000 px"},
      {with(shape("mug", Json{{1, 1}, {2, "x"}, {3, 3}})), "pairs [x, y]"},
      {with(shape("mug", Json{{1, 1}, {2}, {3, 3}})), "pairs [x, y]"},
      {with(shape("mug", Json(7))), "pairs [x, y]"},
      {with(Json{{"points", rectangle(1, 1, 5, 5)}}), "shape 3 has no label"},
      {with(Json(7)), "shape 3 has no label"},
  };
  for (const Broken& broken : cases) {
    const LabelmeFolder folder(broken.json);
    EXPECT_TRUE(holds(folder.refusal(), broken.said)) << folder.refusal() << "\nexpected: " << broken.said;
    const DatasetReport report = check_dataset(folder.path(), labels());
    ASSERT_EQ(report.problem_count, 1u) << broken.said;
    EXPECT_TRUE(holds(report.problems[0], broken.said)) << report.problems[0];
  }
}

TEST(Annotations, HostileJsonIsRefused) {
  const LabelmeFolder folder{shape("mug", rectangle(5, 5, 30, 40)), shape("handle", rectangle(6, 6, 9, 9))};
  const std::string nested = std::string(300000, '[') + std::string(300000, ']');
  const std::vector<std::pair<std::string, std::string>> cases{
      {"{\"shapes\": [], \"flags\": " + nested + "}", "nested too deeply"},
      {"{\"shapes\": [{\"label\": \"mug\", \"points\": [[NaN, 1], [2, 2], [3, 1]]}]}", "NaN"},
      {"{\"shapes\": [{\"label\": \"mug\", \"points\": [[1e999, 1], [2, 2], [3, 1]]}]}", "out of range"},
      {"{\"shapes\": [", "is no valid JSON"},
      {"", "is no valid JSON"},
      {"\xff\xfe", "is no valid JSON"},
      {"{\"shapes\": 3}", "'shapes' is missing"},
  };
  for (const auto& [content, said] : cases) {
    folder.put("photo2.json", content);
    const std::string message = folder.refusal();
    EXPECT_TRUE(holds(message, "photo2.json") && holds(message, said)) << message;
  }
}

TEST(Annotations, CheckNamesEveryFile) {
  const LabelmeFolder folder{shape("mug", rectangle(5, 5, 30, 40)), shape("handle", rectangle(6, 6, 9, 9))};
  folder.put("bad1.json", "{");
  folder.put("bad2.json", labelme(Json::array({shape("mug", rectangle(5, 5, 6, 6))}), "no.png").dump());
  folder.put(
      "bad3.json",
      labelme(Json::array({shape("mug", rectangle(90, 5, 95, 6)), shape("handle", Json{{1, 2}})})).dump());
  const DatasetReport report = check_dataset(folder.path(), labels());
  EXPECT_EQ(report.problem_count, 4u);
  EXPECT_EQ(report.summary.classes.at("mug").objects, 1);
  EXPECT_EQ(report.summary.classes.at("mug").label_px, 9);
  const DatasetReport cut = check_dataset(folder.path(), labels(), 2);
  EXPECT_EQ(cut.problems.size(), 2u);
  EXPECT_EQ(cut.problem_count, 4u);
}

// ---- COCO ----

Json flat(const Json& points) {
  Json list = Json::array();
  for (const Json& point : points) list.insert(list.end(), point.begin(), point.end());
  return Json::array({list});
}

/// One image, a mug (category 3) with a handle (category 5).
Json coco() {
  return {
      {"images", {{{"id", 11}, {"file_name", "photo.png"}, {"width", 64}, {"height", 48}}}},
      {"categories", {{{"id", 3}, {"name", "mug"}}, {{"id", 5}, {"name", "handle"}}}},
      {"annotations",
       {{{"id", 1}, {"image_id", 11}, {"category_id", 3}, {"segmentation", flat(rectangle(5, 5, 60, 40))}},
        {{"id", 2}, {"image_id", 11}, {"category_id", 5}, {"segmentation", flat(rectangle(6, 6, 9, 9))}}}}};
}

struct CocoFolder : TemporaryFolder {
  explicit CocoFolder(const Json& json, const std::string& file = "coco.json",
                      const std::string& image = "photo.png") {
    put(file, json.dump());
    fs::create_directories((*this / image).parent_path());
    write_image(*this / image, testing::random_texture(image_size, 1));
  }
};

std::vector<LabelledView> load_coco_segmentation(const Json& segmentation) {
  Json json = coco();
  json["annotations"][0]["segmentation"] = segmentation;
  json["annotations"].erase(1);
  json["annotations"].push_back(
      {{"id", 9}, {"image_id", 11}, {"category_id", 5}, {"segmentation", segmentation}});
  const CocoFolder folder(json);
  return load_dataset(folder.path(), labels());
}

TEST(Coco, PolygonsAreUnited) {
  const CocoFolder folder(coco());
  const std::vector<LabelledView> views = load_dataset(folder.path(), labels());
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(cv::boundingRect(views[0].mask), cv::Rect(5, 5, 55, 35));
  EXPECT_EQ(cv::boundingRect(views[0].label), cv::Rect(6, 6, 3, 3));
  EXPECT_EQ(views[0].source, (folder / "photo.png").string());
  Json two = flat(rectangle(1, 1, 5, 5));
  two.push_back({3, 3, 9, 3, 9, 9, 3, 9});
  EXPECT_EQ(cv::countNonZero(load_coco_segmentation(two)[0].mask), 16 + 36 - 4);
}

/// The pixels between two circles about (30, 22).
cv::Mat ring(double inner, double outer) {
  cv::Mat mask = cv::Mat::zeros(image_size, CV_8UC1);
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      const double square = (u - 30) * (u - 30) + (v - 22) * (v - 22);
      if (square >= inner * inner && square <= outer * outer) mask.at<uchar>(v, u) = 255;
    }
  }
  return mask;
}

TEST(Coco, ReadsRuns) {
  const cv::Mat truth = ring(9, 17);
  Json counts = Json::array();
  int run = 0;
  uchar value = 0;
  for (int u = 0; u < 64; ++u) {
    for (int v = 0; v < 48; ++v) {
      if (truth.at<uchar>(v, u) != value) counts.push_back(run), run = 0, value = truth.at<uchar>(v, u);
      ++run;
    }
  }
  counts.push_back(run);
  const auto views = load_coco_segmentation({{"size", {48, 64}}, {"counts", counts}});
  EXPECT_EQ(cv::countNonZero(views.at(0).mask != truth), 0);
}

TEST(Coco, ReadsCompressedRuns) {
  // As pycocotools 2 encodes them.
  const auto views = load_coco_segmentation(
      {{"size", {48, 64}},
       {"counts",
        "Vd01Z1:H6L2N2M4N0O2N2N^"
        "OG08OJ06OL030O00O20N020N020N020M130MO30N020N020N020N10010M041J061H09b02N2N102L3N2N4J8F_g0"}});
  EXPECT_EQ(cv::countNonZero(views.at(0).mask != ring(9, 17)), 0);
  cv::Mat truth = ring(0, 9);
  truth.colRange(0, 5) = 255;
  const auto disc = load_coco_segmentation(
      {{"size", {48, 64}}, {"counts", "0`7fh0aHeXO8K2N2N2N2O00000O20N1000001N2N2N2N5H^S1"}});
  EXPECT_EQ(cv::countNonZero(disc.at(0).mask != truth), 0);
  const auto full = load_coco_segmentation({{"size", {48, 64}}, {"counts", "0PP3"}});
  EXPECT_EQ(cv::countNonZero(full.at(0).mask), 48 * 64);
}

TEST(Coco, FindsItsImages) {
  const std::vector<std::array<std::string, 3>> layouts{
      {"coco.json", "photo.png", "."},
      {"coco.json", "images/photo.png", "coco.json"},
      {"annotations/instances_val.json", "val/photo.png", "."},
      {"annotations/instances_val.json", "images/val/photo.png", "."},
      {"annotations/instances_default.json", "images/photo.png", "annotations/instances_default.json"}};
  for (const auto& [file, image, path] : layouts) {
    const CocoFolder folder(coco(), file, image);
    EXPECT_EQ(detect_dataset_format(folder / path), DatasetFormat::coco) << file;
    EXPECT_EQ(load_dataset(folder / path, labels()).size(), 1u) << file << " " << image;
    DatasetOptions options = labels();
    options.images = {"photo.png"};
    EXPECT_EQ(load_dataset(folder / path, options).at(0).image_name, "photo.png");
    options.images = {"other.png"};
    EXPECT_THROW(load_dataset(folder / path, options), InvalidInput);
  }
}

TEST(Coco, FilesThatAreBrokenAreNamed) {
  struct Broken {
    std::string pointer;  // what is replaced
    Json value;
    std::string said;
  };
  const auto runs = [](const Json& counts, const Json& size = {48, 64}) {
    return Json{{"size", size}, {"counts", counts}};
  };
  const std::string mug = "/annotations/0/segmentation";
  const std::vector<Broken> cases{
      {"/images", 3, "'images' is missing"},
      {"/categories", nullptr, "'categories' is missing"},
      {"/images/0/id", "a", "image 1 lacks"},
      {"/images/0/width", 1e30, "image 1 lacks"},
      {"/images/0/width", 63, "photo.png: is 64x48 px, expected 63x48"},
      {"/images/0/file_name", "../photo.png", "expected a relative path inside of"},
      {"/images/0/file_name", "/photo.png", "expected a relative path inside of"},
      {"/images/0/file_name", "none.png", "none.png: no such file"},
      {"/images/1",
       {{"id", 11}, {"file_name", "b.png"}, {"width", 64}, {"height", 48}},
       "the image id 11 is given twice"},
      {"/images/1",
       {{"id", 12}, {"file_name", "photo.png"}, {"width", 64}, {"height", 48}},
       "two images have the file_name 'photo.png'"},
      {"/categories/2", {{"id", 3}, {"name", "cup"}}, "the category id 3 is given twice"},
      {"/categories/2", {{"id", 6}}, "category 3 lacks"},
      {"/annotations/0/image_id", 12, "annotation 1: 'image_id' is 12"},
      {"/annotations/0/category_id", nullptr, "annotation 1: 'category_id' is null"},
      {"/annotations/1/id", 1, "the annotation id 1 is given twice"},
      {"/annotations", Json::array(), "holds no annotation"},
      {mug, nullptr, "has no 'segmentation'"},
      {mug, Json::array(), "'segmentation' is empty"},
      {mug, {{1, 2, 3, 4}}, "expected polygons"},
      {mug, {{1, 2, 3, 4, 5, 6, 7}}, "expected polygons"},
      {mug, {{1, 2, 3, 4, 5, "6"}}, "within 1000000 px"},
      {mug, {{1, 2, 3, 4, 5, 1e300}}, "within 1000000 px"},
      {mug, {{100, 2, 130, 4, 150, 40}}, "covers no pixel"},
      {mug, runs({0, 3072}, {64, 48}), "'size' is [64,48], expected [48,64]"},
      {mug, runs({0, 3071}), "the runs cover less than the 3072 px"},
      {mug, runs({0, 3073}), "the runs cover more"},
      {mug, runs({0, 9223372036854775807, 9223372036854775807}), "the runs cover more"},
      {mug, runs({-1, 3073}), "'counts' holds -1"},
      {mug, runs({0.5, 3071.5}), "'counts' holds 0.5"},
      {mug, runs("PP~"), "'counts' is neither"},
      {mug, runs("oooooooooooooooooooooo"), "'counts' is neither"},
      {mug, runs("PPP"), "'counts' is neither"},  // ends in the middle of a number
      {mug, runs("1"), "the runs cover less"},
      {mug, runs(nullptr), "'counts' is neither"},
      {mug, runs({3072}), "covers no pixel"},
  };
  for (const Broken& broken : cases) {
    Json json = coco();
    json[Json::json_pointer(broken.pointer)] = broken.value;
    const CocoFolder folder(json);
    const std::string message = message_of<InvalidInput>([&] {
      load_dataset(folder / "coco.json", [] {
        DatasetOptions options = labels();
        options.format = DatasetFormat::coco;
        return options;
      }());
    });
    EXPECT_TRUE(holds(message, broken.said)) << message << "\nexpected: " << broken.said;
  }
}

TEST(Coco, OtherLabelsMayBeBoxes) {
  Json json = coco();
  json["categories"].push_back({{"id", 6}, {"name", "table"}});
  json["annotations"].push_back({{"id", 7}, {"image_id", 11}, {"category_id", 6}, {"bbox", {1, 2, 3, 4}}});
  const CocoFolder folder(json);
  EXPECT_EQ(load_dataset(folder.path(), labels()).size(), 1u);
  EXPECT_EQ(check_dataset(folder.path()).problem_count, 1u);  // no labels given: every outline counts
}

// ---- which layout ----

TEST(DatasetFormats, AreToldApart) {
  const LabelmeFolder labelme_folder{shape("mug", rectangle(5, 5, 30, 40))};
  EXPECT_EQ(detect_dataset_format(labelme_folder.path()), DatasetFormat::labelme);
  EXPECT_THROW(detect_dataset_format(labelme_folder / "photo.json"), InvalidInput);
  EXPECT_THROW(detect_dataset_format(labelme_folder / "photo.png"), InvalidInput);
  labelme_folder.put("all.json", coco().dump());
  const std::string both = message_of<InvalidInput>([&] { detect_dataset_format(labelme_folder.path()); });
  EXPECT_TRUE(holds(both, "--format")) << both;
  DatasetOptions forced = labels();
  forced.format = DatasetFormat::coco;
  EXPECT_EQ(load_dataset(labelme_folder.path(), forced).size(), 1u);

  const CocoFolder named_like_ours(coco(), "dataset.json");
  EXPECT_EQ(detect_dataset_format(named_like_ours.path()), DatasetFormat::coco);
  named_like_ours.put("second.json", coco().dump());
  const std::string several =
      message_of<InvalidInput>([&] { load_dataset(named_like_ours.path(), labels()); });
  EXPECT_TRUE(holds(several, "dataset.json, second.json")) << several;

  const TemporaryFolder empty;
  EXPECT_THROW(detect_dataset_format(empty.path()), InvalidInput);
  empty.put("broken.json", "{");
  const std::string broken = message_of<InvalidInput>([&] { detect_dataset_format(empty.path()); });
  EXPECT_TRUE(holds(broken, "broken.json")) << broken;
}

}  // namespace
}  // namespace graspctx
