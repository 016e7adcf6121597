#include <gtest/gtest.h>

#include <clocale>
#include <functional>
#include <locale>
#include <map>
#include <sstream>

#include "graspctx/error.hpp"
#include "graspctx/io/calibration_file.hpp"
#include "temporary_folder.hpp"

namespace graspctx {
namespace {

using testing::message_of;
using testing::TemporaryFolder;
namespace fs = std::filesystem;

const char* const middlebury =
    "cam0=[994.978 0 311.193; 0 994.978 254.877; 0 0 1]\n"
    "cam1=[994.978 0 342.279; 0 994.978 254.877; 0 0 1]\n"
    "doffs=31.086\nbaseline=193.001\nwidth=741\nheight=500\nndisp=70\n";

/// One camera_info file; the entries can be replaced one by one.
std::map<std::string, std::string> camera_info(bool right) {
  return {{"image_width", "640"},
          {"image_height", "480"},
          {"camera_name", "narrow_stereo"},
          {"camera_matrix", "\n  rows: 3\n  cols: 3\n  data: [620.5, 0, 321.5, 0, 621.5, 239.25, 0, 0, 1]"},
          {"distortion_model", "plumb_bob"},
          {"distortion_coefficients", "\n  rows: 1\n  cols: 5\n  data: [-0.3, 0.1, 0.001, -0.002, 0.0]"},
          {"rectification_matrix", "\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]"},
          {"projection_matrix", std::string("\n  rows: 3\n  cols: 4\n  data: [600.0, 0., 318.5, ") +
                                    (right ? "-48.0" : "0.0") + ", 0., 600.0, 241.5, 0., 0., 0., 1., 0.]"}};
}

std::string yaml(const std::map<std::string, std::string>& entries) {
  std::string text;
  for (const auto& [key, value] : entries) text += key + ": " + value + "\n";
  return text;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

class CalibrationFile : public ::testing::Test {
 protected:
  StereoCamera load(const std::string& text) { return load_calibration({folder.put("calib.txt", text)}); }
  StereoCamera load_pair(const std::string& left, const std::string& right, bool rectified = false) {
    return load_calibration({folder.put("left.yaml", left), folder.put("right.yaml", right)}, rectified);
  }
  TemporaryFolder folder;
};

TEST_F(CalibrationFile, ReadsMiddlebury) {
  for (const std::string& text :
       {std::string(middlebury), replaced(middlebury, "\ndoffs=", "\r\n\r\n# a comment\ndoffs = ")}) {
    const StereoCamera camera = load(text);
    EXPECT_EQ(camera.focal_px, 994.978);
    EXPECT_EQ(camera.centre_px, Eigen::Vector2d(311.193, 254.877));
    EXPECT_EQ(camera.doffs_px, 31.086);
    EXPECT_DOUBLE_EQ(camera.baseline_m, 0.193001);
    EXPECT_EQ(camera.width_px, 741);
    EXPECT_EQ(camera.height_px, 500);
    EXPECT_FALSE(camera.raw);
  }
}

TEST_F(CalibrationFile, DepthOfAMiddleburyDisparityIsTheSetsOwn) {
  // Z = baseline · f / (d + doffs), in mm, as the data set's page defines it.
  EXPECT_NEAR(load(middlebury).depth_m(40.0), 193.001 * 994.978 / (40.0 + 31.086) / 1000, 1e-12);
}

TEST_F(CalibrationFile, RefusesBrokenMiddlebury) {
  const std::vector<std::pair<std::string, std::string>> damages{
      {"cam0=", "cam9="},
      {"doffs=31.086", ""},
      {"baseline=193.001", ""},
      {"width=741", ""},
      {"height=500", ""},
      {"baseline=193.001", "baseline=0"},
      {"baseline=193.001", "baseline=-193"},
      {"baseline=193.001", "baseline=nan"},
      {"baseline=193.001", "baseline=inf"},
      {"baseline=193.001", "baseline=1e400"},
      {"baseline=193.001", "baseline=1e300"},
      {"baseline=193.001", "baseline=193,001"},
      {"baseline=193.001", "baseline=193.001mm"},
      {"baseline=193.001", "baseline="},
      {"baseline=193.001", "baseline"},
      {"baseline=193.001", "baseline=193\nbaseline=194"},
      {"doffs=31.086", "doffs=0x10"},
      {"doffs=31.086", "doffs=-31.086"},
      {"width=741", "width=741.5"},
      {"width=741", "width=-741"},
      {"width=741", "width=99999999999"},
      {"height=500", "height=0"},
      {"[994.978 0 311.193;", "[0 0 311.193;"},
      {"[994.978 0 311.193;", "[-994.978 0 311.193;"},
      {"[994.978 0 311.193;", "[994.978 0;"},
      {"[994.978 0 311.193;", "[994.978 0 311.193 5;"},
      {"[994.978 0 311.193;", "[994.978 0 nan;"},
      {"[994.978 0 311.193;", "[994.978 3 311.193;"},
      {"[994.978 0 311.193;", "994.978 0 311.193;"},
      {"[994.978 0 311.193;", "[1e200 0 311.193;"},
      {"[994.978 0 342.279;", "[984.978 0 342.279;"},
      {"254.877; 0 0 1]\ncam1", "255.877; 0 0 1]\ncam1"},
      {"0 0 1]\n", "0 0 1; 0 0 0]\n"},
      {"0 0 1]\n", "0 0 2]\n"},
      {"ndisp=70", std::string("ndisp=7\0", 8)},
  };
  for (const auto& [what, with] : damages) {
    const std::string message =
        message_of<InvalidInput>([&, &what = what, &with = with] { load(replaced(middlebury, what, with)); });
    EXPECT_NE(message.find("calib.txt"), std::string::npos) << what << " -> " << with << ": " << message;
  }
  EXPECT_THROW(load(""), InvalidInput);
  EXPECT_THROW(load("\x89PNG\r\n\x1a\n"), InvalidInput);
  EXPECT_THROW(load(std::string(2 << 20, '\n')), InvalidInput);
  EXPECT_THROW(load_calibration({folder / "missing.txt"}), InvalidInput);
  EXPECT_THROW(load_calibration({}), InvalidInput);
}

TEST_F(CalibrationFile, TruncatedMiddleburyIsRefusedOrTellsOfAnotherImageSize) {
  const std::string text(middlebury);
  const std::size_t size_is_complete = text.find("500") + 3;
  for (std::size_t size = 0; size < size_is_complete; ++size) {
    try {
      const StereoCamera camera = load(text.substr(0, size));
      EXPECT_NE(camera.height_px, 500) << size;
    } catch (const InvalidInput&) {
    }
  }
}

TEST_F(CalibrationFile, ReadsACameraInfoPair) {
  const StereoCamera camera = load_pair(yaml(camera_info(false)), yaml(camera_info(true)));
  EXPECT_EQ(camera.focal_px, 600);
  EXPECT_EQ(camera.centre_px, Eigen::Vector2d(318.5, 241.5));
  EXPECT_DOUBLE_EQ(camera.baseline_m, 0.08);
  EXPECT_EQ(camera.doffs_px, 0);
  EXPECT_EQ(camera.width_px, 640);
  ASSERT_TRUE(camera.raw);
  const RawView& left = (*camera.raw)[0];
  EXPECT_EQ(left.camera_matrix(0, 2), 321.5);
  EXPECT_EQ(left.camera_matrix(1, 1), 621.5);
  EXPECT_EQ(left.distortion, (std::vector<double>{-0.3, 0.1, 0.001, -0.002, 0}));
  EXPECT_FALSE(load_pair(yaml(camera_info(false)), yaml(camera_info(true)), true).raw);
}

TEST_F(CalibrationFile, UndistortedPairNeedsNoRectification) {
  std::string texts[2];
  for (const bool right : {false, true}) {
    auto info = camera_info(right);
    info["distortion_coefficients"] = "{rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}";
    info["camera_matrix"] = "{rows: 3, cols: 3, data: [600, 0, 318.5, 0, 600, 241.5, 0, 0, 1]}";
    texts[right] = yaml(info);
  }
  EXPECT_FALSE(load_pair(texts[0], texts[1]).raw);
}

TEST_F(CalibrationFile, KnowsTheDistortionModels) {
  for (const auto& [model, count] :
       {std::pair{"plumb_bob", 4}, {"plumb_bob", 5}, {"rational_polynomial", 8}, {"equidistant", 4}}) {
    auto info = camera_info(false);
    info["distortion_model"] = model;
    std::string data = "0.01";
    for (int i = 1; i < count; ++i) data += ", 0.01";
    info["distortion_coefficients"] = "{rows: 1, cols: " + std::to_string(count) + ", data: [" + data + "]}";
    const StereoCamera camera = load_pair(yaml(info), yaml(camera_info(true)));
    EXPECT_EQ((*camera.raw)[0].distortion.size(), static_cast<std::size_t>(count));
    EXPECT_EQ((*camera.raw)[0].distortion_model, std::string(model) == "equidistant"
                                                     ? RawView::Distortion::equidistant
                                                     : RawView::Distortion::plumb_bob);
  }
}

TEST_F(CalibrationFile, RefusesBrokenCameraInfo) {
  const std::vector<std::pair<std::string, std::string>> entries{
      {"image_width", "0"},
      {"image_width", "-640"},
      {"image_width", "wide"},
      {"image_width", "[640]"},
      {"image_height", "480.5"},
      {"camera_matrix", "5"},
      {"camera_matrix", "{rows: 3, cols: 3, data: [620, 0, 321, 0, 620, 239, 0, 0]}"},
      {"camera_matrix", "{rows: -3, cols: -3, data: [620, 0, 321, 0, 620, 239, 0, 0, 1]}"},
      {"camera_matrix", "{rows: 3, cols: 3, data: [.nan, 0, 321, 0, 620, 239, 0, 0, 1]}"},
      {"camera_matrix", "{rows: 3, cols: 3, data: [0, 0, 321, 0, 620, 239, 0, 0, 1]}"},
      {"camera_matrix", "{rows: 3, cols: 3, data: [620, 0, 321, 0, 620, 239, 0, 0, [1]]}"},
      {"camera_matrix", "{rows: 3, cols: 3}"},
      {"camera_matrix", "{rows: 3, cols: 3, data: {a: 1}}"},
      {"distortion_model", "fisheye62"},
      {"distortion_model", "equidistant"},
      {"distortion_coefficients", "{rows: 1, cols: 3, data: [0, 0, 0]}"},
      {"distortion_coefficients", "{rows: 1, cols: 5, data: [0, 0, .inf, 0, 0]}"},
      {"distortion_coefficients", "{rows: 2000000000, cols: 2000000000, data: []}"},
      {"rectification_matrix", "{rows: 3, cols: 3, data: [1, 0, 0, 0, 2, 0, 0, 0, 1]}"},
      {"rectification_matrix", "{rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, -1]}"},
      {"projection_matrix", "{rows: 4, cols: 3, data: [600, 0, 318, -48, 0, 600, 241, 0, 0, 0, 1]}"},
      {"projection_matrix", "{rows: 3, cols: 4, data: [600, 0, 318, 48, 0, 600, 241.5, 0, 0, 0, 1, 0]}"},
      {"projection_matrix", "{rows: 3, cols: 4, data: [600, 0, 318, 0, 0, 600, 241.5, 0, 0, 0, 1, 0]}"},
      {"projection_matrix", "{rows: 3, cols: 4, data: [600, 0, 318, -48, 0, 500, 241.5, 0, 0, 0, 1, 0]}"},
      {"projection_matrix", "{rows: 3, cols: 4, data: [590, 0, 318, -48, 0, 590, 241.5, 0, 0, 0, 1, 0]}"},
      {"projection_matrix", "{rows: 3, cols: 4, data: [600, 0, 318, -48, 0, 600, 231.5, 0, 0, 0, 1, 0]}"},
      {"projection_matrix", "{rows: 3, cols: 4, data: [600, 0, 318, -1e9, 0, 600, 241.5, 0, 0, 0, 1, 0]}"},
  };
  const std::string left = yaml(camera_info(false));
  for (const auto& [key, value] : entries) {
    auto info = camera_info(true);
    info[key] = value;
    const std::string message = message_of<InvalidInput>([&] { load_pair(left, yaml(info)); });
    EXPECT_NE(message.find("right.yaml"), std::string::npos) << key << ": " << value << ": " << message;
  }
  for (const auto& [key, value] : camera_info(true)) {
    if (key == "camera_name") continue;
    auto info = camera_info(true);
    info.erase(key);
    EXPECT_THROW(load_pair(left, yaml(info)), InvalidInput) << "without " << key;
    EXPECT_THROW(load_pair(left, yaml(camera_info(true)) + key + ": " + value + "\n"), InvalidInput)
        << "twice " << key;
  }
  for (const std::string& text :
       {std::string("just words"), std::string("- a\n- b\n"), std::string("a: [1, 2"),
        std::string("a: *nowhere\n"), std::string("\xff\xfe\x00")}) {
    EXPECT_THROW(load_pair(left, text), InvalidInput) << text;
  }
  // Swapped, or one file where two belong.
  EXPECT_THROW(load_pair(yaml(camera_info(true)), left), InvalidInput);
  EXPECT_THROW(load_pair(left, left), InvalidInput);
  EXPECT_THROW(load_calibration({folder / "left.yaml"}), InvalidInput);
}

TEST_F(CalibrationFile, DeepNestingIsRefusedNotRecursedInto) {
  const std::string left = yaml(camera_info(false));
  std::string block;
  for (int i = 0; i < 900; ++i) block += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  std::string compact = "a:\n ";
  for (int i = 0; i < 490; ++i) compact += "- ";
  for (const std::string& text :
       {"a: " + std::string(400000, '['), "a: " + std::string(60, '[') + std::string(60, ']'),
        "a: " + std::string(400000, '{'), block, compact, std::string(100000, '-'),
        std::string(400000, ' ') + "a: 1"}) {
    EXPECT_THROW(load_pair(left, text), InvalidInput) << text.substr(0, 20);
  }
}

TEST_F(CalibrationFile, DoesNotDependOnTheLocale) {
  struct CommaPoint : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new CommaPoint));
  const StereoCamera camera = load(middlebury);
  const StereoCamera pair = load_pair(yaml(camera_info(false)), yaml(camera_info(true)));
  std::locale::global(before);
  EXPECT_EQ(camera.focal_px, 994.978);
  EXPECT_EQ(pair.centre_px.x(), 318.5);
}

}  // namespace
}  // namespace graspctx
