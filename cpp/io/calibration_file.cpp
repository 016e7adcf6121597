#include "graspctx/io/calibration_file.hpp"

#include <yaml-cpp/yaml.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "detail/number.hpp"
#include "detail/number_text.hpp"
#include "graspctx/error.hpp"
#include "graspctx/io/atomic_file.hpp"

namespace graspctx {

namespace {

namespace fs = std::filesystem;
using Matrix3x4d = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
using detail::number_text;
using Matrix3dRowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr std::size_t max_file_bytes = 1 << 20;
constexpr double max_side_px = 32767;
constexpr double same_px = 0.01;  // numbers of one rectification agree at least to this

/// Errors that name the file.
class Checker {
 public:
  explicit Checker(fs::path file) : file_(std::move(file)) {}
  void require(bool condition, const std::string& message) const {
    if (!condition) fail(message);
  }
  [[noreturn]] void fail(const std::string& message) const {
    throw InvalidInput(file_.string() + ": " + message);
  }

 private:
  fs::path file_;
};

/// A piece of the file for a message: short, and of printable characters.
std::string quoted(std::string text) {
  const std::size_t longest = 40;
  if (text.size() > longest) text = text.substr(0, longest) + "...";
  for (char& c : text) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return "'" + text + "'";
}

/// Numbers that no camera has would overflow somewhere further on.
void check_plausible(const StereoCamera& camera, const Checker& check) {
  check.require(camera.focal_px >= 1 && camera.focal_px <= 1e6,
                "the focal length is " + number_text(camera.focal_px) + " px, expected 1 to 1e6");
  check.require(camera.baseline_m >= 1e-4 && camera.baseline_m <= 1e3,
                "the baseline is " + number_text(camera.baseline_m) + " m, expected 0.0001 to 1000");
  check.require(camera.centre_px.cwiseAbs().maxCoeff() <= 1e6 && std::abs(camera.doffs_px) <= 1e6,
                "a principal point is more than 1e6 px away");
}

int image_side(const std::optional<int>& value, const std::string& name, const std::string& text,
               const Checker& check) {
  check.require(value && *value >= 1 && *value <= max_side_px,
                name + " is " + quoted(text) + ", expected a whole number of pixels from 1 to 32767");
  return *value;
}

std::string trimmed(const std::string& text) {
  const char* blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

// ---- Middlebury calib.txt: KEY=VALUE lines ----

/// cam0=[f 0 cx; 0 f cy; 0 0 1]
Eigen::Matrix3d parse_middlebury_matrix(const std::string& name, const std::string& text,
                                        const Checker& check) {
  const std::string shape = name + " must be a matrix [f 0 cx; 0 f cy; 0 0 1]";
  check.require(text.size() >= 2 && text.front() == '[' && text.back() == ']', shape);
  Eigen::Matrix3d matrix;
  std::istringstream rows(text.substr(1, text.size() - 2));
  std::string row;
  int row_count = 0;
  while (std::getline(rows, row, ';')) {
    check.require(row_count < 3, shape);
    std::istringstream numbers(row);
    std::string number;
    int column_count = 0;
    while (numbers >> number) {
      const std::optional<double> value = detail::parse_number(number);
      check.require(value.has_value(), name + ": " + quoted(number) + " is no finite number");
      check.require(column_count < 3, shape);
      matrix(row_count, column_count++) = *value;
    }
    check.require(column_count == 3, shape);
    ++row_count;
  }
  check.require(row_count == 3, shape);
  const bool pinhole =
      matrix(0, 1) == 0 && matrix(1, 0) == 0 && matrix(2, 0) == 0 && matrix(2, 1) == 0 && matrix(2, 2) == 1;
  check.require(pinhole, shape);
  check.require(matrix(0, 0) > 0 && std::abs(matrix(0, 0) - matrix(1, 1)) <= same_px,
                name + ": expected one positive focal length for both axes");
  return matrix;
}

StereoCamera parse_middlebury(const std::string& text, const Checker& check) {
  std::map<std::string, std::string> entries;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    const std::size_t equals = line.find('=');
    check.require(equals != std::string::npos,
                  "line " + std::to_string(number) + " is no KEY=VALUE, expected a Middlebury calib.txt");
    const std::string key = trimmed(line.substr(0, equals));
    check.require(entries.emplace(key, trimmed(line.substr(equals + 1))).second,
                  quoted(key) + " is given twice");
  }
  const auto entry = [&](const std::string& key) -> const std::string& {
    const auto found = entries.find(key);
    check.require(found != entries.end(), "'" + key +
                                              "' is missing, expected a Middlebury calib.txt with "
                                              "cam0, cam1, doffs, baseline, width and height");
    return found->second;
  };
  const auto number = [&](const std::string& key) {
    const std::optional<double> value = detail::parse_number(entry(key));
    check.require(value.has_value(), key + " is " + quoted(entry(key)) + ", expected a finite number");
    return *value;
  };

  const Eigen::Matrix3d left = parse_middlebury_matrix("cam0", entry("cam0"), check);
  const Eigen::Matrix3d right = parse_middlebury_matrix("cam1", entry("cam1"), check);
  StereoCamera camera;
  camera.focal_px = left(0, 0);
  camera.centre_px = {left(0, 2), left(1, 2)};
  camera.doffs_px = number("doffs");
  camera.baseline_m = number("baseline") / 1000;
  camera.width_px = image_side(detail::parse_integer(entry("width")), "width", entry("width"), check);
  camera.height_px = image_side(detail::parse_integer(entry("height")), "height", entry("height"), check);
  check.require(
      std::abs(left(0, 0) - right(0, 0)) <= same_px && std::abs(left(1, 2) - right(1, 2)) <= same_px,
      "cam0 and cam1 differ in focal length or row of the principal point, expected a rectified pair");
  const double doffs_px = right(0, 2) - left(0, 2);
  check.require(std::abs(camera.doffs_px - doffs_px) <= 0.05,
                "doffs is " + number_text(camera.doffs_px) +
                    ", expected cx of cam1 minus cx of cam0: " + number_text(doffs_px));
  return camera;
}

// ---- ROS camera_info YAML, one file for each camera ----

/// yaml-cpp descends once for each level of nesting. A camera_info file nests three levels: whatever could
/// nest deeply enough to exhaust the stack is refused before it is parsed.
void check_nesting(const std::string& text, const Checker& check) {
  const auto opening = std::count_if(text.begin(), text.end(), [](char c) { return c == '[' || c == '{'; });
  std::size_t longest_line = 0, start = 0;  // each level of block nesting takes a column
  while (start < text.size()) {
    const std::size_t end = std::min(text.find_first_of("\r\n", start), text.size());
    longest_line = std::max(longest_line, end - start);
    start = end + 1;
  }
  check.require(opening <= 64 && longest_line <= 1000,
                "is nested too deeply, expected a ROS camera_info YAML");
}

/// One camera_info file.
struct CameraInfo {
  int width_px = 0, height_px = 0;
  RawView raw;
  Matrix3x4d projection;
};

YAML::Node child(const YAML::Node& parent, const std::string& key, const Checker& check) {
  check.require(parent.IsMap(), "is no mapping, expected a ROS camera_info YAML");
  YAML::Node found;
  int count = 0;
  for (const auto& item : parent) {
    if (item.first.IsScalar() && item.first.Scalar() == key) {
      found.reset(item.second);
      ++count;
    }
  }
  check.require(count > 0, "'" + key + "' is missing, expected a ROS camera_info YAML");
  check.require(count == 1, "'" + key + "' is given twice");
  return found;
}

std::string scalar(const YAML::Node& parent, const std::string& key, const Checker& check) {
  const YAML::Node node = child(parent, key, check);
  check.require(node.IsScalar(), "'" + key + "' must be a single value");
  return node.Scalar();
}

std::vector<double> numbers(const YAML::Node& root, const std::string& key, const Checker& check) {
  const YAML::Node node = child(root, key, check);
  check.require(node.IsMap(), "'" + key + "' must have rows, cols and data");
  const std::optional<int> rows = detail::parse_integer(scalar(node, "rows", check));
  const std::optional<int> cols = detail::parse_integer(scalar(node, "cols", check));
  check.require(rows && cols && *rows >= 0 && *cols >= 0 && *rows <= 100 && *cols <= 100,
                "'" + key + "': rows and cols must be small whole numbers");
  const YAML::Node data = child(node, "data", check);
  check.require(data.IsSequence() && data.size() == static_cast<std::size_t>(*rows) * *cols,
                "'" + key + "': data has " + std::to_string(data.IsSequence() ? data.size() : 0) +
                    " entries, expected rows x cols = " + std::to_string(*rows * *cols));
  std::vector<double> values;
  for (const YAML::Node& item : data) {
    const std::optional<double> value = item.IsScalar() ? detail::parse_number(item.Scalar()) : std::nullopt;
    check.require(value.has_value(), "'" + key + "': data must be finite numbers");
    values.push_back(*value);
  }
  return values;
}

template <typename Matrix>
Matrix matrix(const YAML::Node& root, const std::string& key, const Checker& check) {
  const std::vector<double> values = numbers(root, key, check);
  check.require(values.size() == static_cast<std::size_t>(Matrix::SizeAtCompileTime),
                "'" + key + "' has " + std::to_string(values.size()) + " numbers, expected " +
                    std::to_string(Matrix::RowsAtCompileTime) + "x" +
                    std::to_string(Matrix::ColsAtCompileTime));
  return Eigen::Map<const Matrix>(values.data());
}

CameraInfo read_camera_info(const YAML::Node& root, const Checker& check) {
  CameraInfo info;
  const std::string width = scalar(root, "image_width", check);
  const std::string height = scalar(root, "image_height", check);
  info.width_px = image_side(detail::parse_integer(width), "image_width", width, check);
  info.height_px = image_side(detail::parse_integer(height), "image_height", height, check);

  const Matrix3dRowMajor camera_matrix = matrix<Matrix3dRowMajor>(root, "camera_matrix", check);
  check.require(camera_matrix(0, 0) > 0 && camera_matrix(1, 1) > 0 && camera_matrix(1, 0) == 0 &&
                    camera_matrix.row(2) == Eigen::RowVector3d(0, 0, 1),
                "'camera_matrix' must be [fx s cx; 0 fy cy; 0 0 1] with positive focal lengths");
  info.raw.camera_matrix = camera_matrix;

  const std::string model = scalar(root, "distortion_model", check);
  info.raw.distortion = numbers(root, "distortion_coefficients", check);
  const std::map<std::string, std::set<std::size_t>> counts{
      {"plumb_bob", {0, 4, 5}}, {"rational_polynomial", {8}}, {"equidistant", {4}}};
  const auto known = counts.find(model);
  check.require(known != counts.end(), "distortion_model is " + quoted(model) +
                                           ", expected plumb_bob, rational_polynomial or equidistant");
  check.require(known->second.count(info.raw.distortion.size()) == 1,
                "'distortion_coefficients' has " + std::to_string(info.raw.distortion.size()) +
                    " numbers, expected " + std::to_string(*known->second.rbegin()) + " for " + model);
  info.raw.distortion_model =
      model == "equidistant" ? RawView::Distortion::equidistant : RawView::Distortion::plumb_bob;

  info.raw.rectified_from_raw = matrix<Matrix3dRowMajor>(root, "rectification_matrix", check);
  const Eigen::Matrix3d& rotation = info.raw.rectified_from_raw;
  check.require(
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3 &&
          rotation.determinant() > 0,
      "'rectification_matrix' must be a rotation");

  info.projection = matrix<Matrix3x4d>(root, "projection_matrix", check);
  const Matrix3x4d& p = info.projection;
  check.require(p(0, 0) > 0 && std::abs(p(0, 0) - p(1, 1)) <= same_px,
                "'projection_matrix' must have one positive focal length for both axes");
  check.require(
      p(0, 1) == 0 && p(1, 0) == 0 && std::abs(p(1, 3)) < 1e-9 && p.row(2) == Eigen::RowVector4d(0, 0, 1, 0),
      "'projection_matrix' must be [f 0 cx Tx; 0 f cy 0; 0 0 1 0]");
  return info;
}

CameraInfo parse_camera_info(const std::string& text, const Checker& check) {
  check_nesting(text, check);
  try {
    return read_camera_info(YAML::Load(text), check);
  } catch (const YAML::Exception& error) {
    check.fail(std::string("is no valid YAML (") + error.what() + "), expected a ROS camera_info file");
  }
}

/// No distortion, no rotation, the same intrinsics: the raw image is the rectified one.
bool is_rectified(const CameraInfo& info) {
  const auto& distortion = info.raw.distortion;
  return std::all_of(distortion.begin(), distortion.end(), [](double k) { return k == 0; }) &&
         (info.raw.rectified_from_raw - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-9 &&
         (info.raw.camera_matrix - info.projection.leftCols<3>()).cwiseAbs().maxCoeff() < 1e-6;
}

StereoCamera combine(const CameraInfo& left, const CameraInfo& right, bool images_rectified,
                     const Checker& check_left, const Checker& check_right) {
  const Matrix3x4d& p_left = left.projection;
  const Matrix3x4d& p_right = right.projection;
  check_right.require(left.width_px == right.width_px && left.height_px == right.height_px,
                      "the image size is " + std::to_string(right.width_px) + "x" +
                          std::to_string(right.height_px) + ", expected the left camera's " +
                          std::to_string(left.width_px) + "x" + std::to_string(left.height_px));
  check_left.require(std::abs(p_left(0, 3)) < 1e-9,
                     "projection_matrix has Tx = " + number_text(p_left(0, 3)) +
                         ", expected 0 in the left camera; are left and right swapped?");
  check_right.require(p_right(0, 3) < 0, "projection_matrix has Tx = " + number_text(p_right(0, 3)) +
                                             ", expected -f * baseline < 0 in the right camera");
  check_right.require(
      std::abs(p_left(0, 0) - p_right(0, 0)) <= same_px && std::abs(p_left(1, 2) - p_right(1, 2)) <= same_px,
      "projection_matrix differs from the left camera's in focal length or row of the "
      "principal point, expected a rectified pair");
  StereoCamera camera;
  camera.focal_px = p_left(0, 0);
  camera.centre_px = {p_left(0, 2), p_left(1, 2)};
  camera.baseline_m = -p_right(0, 3) / p_right(0, 0);
  camera.doffs_px = p_right(0, 2) - p_left(0, 2);
  camera.width_px = left.width_px;
  camera.height_px = left.height_px;
  if (!images_rectified && !(is_rectified(left) && is_rectified(right))) {
    camera.raw = std::array<RawView, 2>{left.raw, right.raw};
  }
  return camera;
}

std::string read_text(const fs::path& file) {
  const std::vector<std::uint8_t> bytes = read_file(file, max_file_bytes);
  const Checker check(file);
  check.require(!bytes.empty(), "is empty, expected a calibration");
  check.require(std::find(bytes.begin(), bytes.end(), 0) == bytes.end(),
                "holds zero bytes, expected a calibration in text");
  return std::string(bytes.begin(), bytes.end());
}

}  // namespace

StereoCamera load_calibration(const std::vector<fs::path>& files, bool images_rectified) {
  StereoCamera camera;
  if (files.size() == 1) {
    const Checker check(files[0]);
    const std::string extension = files[0].extension().string();
    check.require(extension != ".yaml" && extension != ".yml",
                  "is one camera_info file, expected two: the left and the right camera's");
    camera = parse_middlebury(read_text(files[0]), check);
    check.require(camera.baseline_m > 0, "the baseline must be positive");
    check_plausible(camera, check);
  } else if (files.size() == 2) {
    const Checker left(files[0]), right(files[1]);
    const CameraInfo left_info = parse_camera_info(read_text(files[0]), left);
    const CameraInfo right_info = parse_camera_info(read_text(files[1]), right);
    camera = combine(left_info, right_info, images_rectified, left, right);
    check_plausible(camera, right);
  } else {
    throw InvalidInput("calibration: got " + std::to_string(files.size()) +
                       " files, expected one calib.txt or two camera_info files");
  }
  try {
    camera.check();
  } catch (const InvalidInput& error) {
    throw InvalidInput(files.back().string() + ": " + error.what());
  }
  return camera;
}

}  // namespace graspctx
