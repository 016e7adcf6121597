#include "arrays.hpp"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace graspctx::python {

namespace {

std::string shape_text(const py::array& array) {
  return py::str(array.attr("shape")).cast<std::string>();
}

std::string dtype_text(const py::array& array) {
  return py::str(array.dtype()).cast<std::string>();
}

[[noreturn]] void wrong_type(const char* name, const std::string& expected, py::handle value) {
  throw py::type_error(std::string(name) + ": expected " + expected + ", got " + describe(value));
}

[[noreturn]] void wrong_value(const char* name, const std::string& expected, py::handle value) {
  throw py::value_error(std::string(name) + ": expected " + expected + ", got " + describe(value));
}

template <typename Scalar>
bool holds(const py::array& array) {
  return array.dtype().is(py::dtype::of<Scalar>()) || array.dtype().equal(py::dtype::of<Scalar>());
}

template <typename Scalar>
py::array_t<Scalar> array_argument(const py::object& value, const char* name, const std::string& expected) {
  if (!py::isinstance<py::array>(value)) wrong_type(name, expected, value);
  const auto array = py::reinterpret_borrow<py::array>(value);
  if (!holds<Scalar>(array)) wrong_type(name, expected, value);
  const bool aligned = (array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) != 0;
  return aligned ? py::reinterpret_borrow<py::array_t<Scalar>>(array)
                 : py::reinterpret_borrow<py::array_t<Scalar>>(array.attr("copy")());
}

/// The pixels of a uint8 (H, W) or (H, W, 3) array; copied only if they are not contiguous along the rows.
cv::Mat pixels_of(const py::array& array) {
  const int rows = static_cast<int>(array.shape(0)), columns = static_cast<int>(array.shape(1));
  const int channels = array.ndim() == 3 ? static_cast<int>(array.shape(2)) : 1;
  const bool contiguous_rows = (array.ndim() == 2 || array.strides(2) == 1) && array.strides(1) == channels &&
                               array.strides(0) >= static_cast<py::ssize_t>(columns) * channels;
  const auto wrap = [&](const py::array& source) {
    // OpenCV takes no pointers to const; nothing writes to an argument.
    return cv::Mat(rows, columns, CV_8UC(channels), const_cast<void*>(source.data()),
                   static_cast<std::size_t>(source.strides(0)));
  };
  if (contiguous_rows) return wrap(array);
  return wrap(py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>(array)).clone();
}

void require_size(const py::array& array, const char* name, const std::string& expected) {
  constexpr py::ssize_t largest = 32767;  // OpenCV's remap and warp take no more
  if (array.shape(0) < 1 || array.shape(1) < 1 || array.shape(0) > largest || array.shape(1) > largest) {
    wrong_value(name, expected + " with sides of 1 to 32767 px", array);
  }
}

template <typename Scalar>
Layout vector_layout(const Scalar* data, std::size_t count) {
  return {data, {static_cast<py::ssize_t>(count)}, {static_cast<py::ssize_t>(sizeof(Scalar))}};
}

template <typename Point>
Layout point_layout(const std::vector<Point>& points) {
  static_assert(sizeof(Point) == 2 * sizeof(typename Point::value_type));
  return {points.data(),
          {static_cast<py::ssize_t>(points.size()), 2},
          {static_cast<py::ssize_t>(sizeof(Point)), static_cast<py::ssize_t>(sizeof(Point) / 2)}};
}

}  // namespace

std::string describe(py::handle value) {
  if (!py::isinstance<py::array>(value)) return py::str(py::type::of(value).attr("__name__"));
  const auto array = py::reinterpret_borrow<py::array>(value);
  return dtype_text(array) + " array of shape " + shape_text(array);
}

cv::Mat image_argument(const py::object& value, const char* name) {
  const std::string expected = "a uint8 array of shape (H, W, 3) or (H, W)";
  const auto array = array_argument<std::uint8_t>(value, name, expected);
  if (array.ndim() != 2 && !(array.ndim() == 3 && array.shape(2) == 3)) wrong_value(name, expected, value);
  require_size(array, name, expected);
  const cv::Mat pixels = pixels_of(array);
  if (pixels.channels() == 1) return pixels;
  cv::Mat bgr;
  cv::cvtColor(pixels, bgr, cv::COLOR_RGB2BGR);
  return bgr;
}

cv::Mat mask_argument(const py::object& value, const char* name) {
  if (value.is_none()) return {};
  const std::string expected = "a uint8 or bool array of shape (H, W)";
  if (!py::isinstance<py::array>(value)) wrong_type(name, expected, value);
  const auto array = py::reinterpret_borrow<py::array>(value);
  if (!holds<std::uint8_t>(array) && !holds<bool>(array)) wrong_type(name, expected, value);
  if (array.ndim() != 2) wrong_value(name, expected, value);
  require_size(array, name, expected);
  return pixels_of(array);
}

FeatureRows::FeatureRows(const py::object& value, const char* name) {
  const std::string expected = "a float32 array of shape (M, D)";
  array_ = array_argument<float>(value, name, expected);
  if (array_.ndim() != 2) wrong_value(name, expected, value);
  constexpr auto scalar = static_cast<py::ssize_t>(sizeof(float));
  const bool contiguous_rows = array_.strides(1) == scalar && array_.strides(0) % scalar == 0 &&
                               array_.strides(0) >= array_.shape(1) * scalar;
  if (!contiguous_rows) array_ = py::array_t<float, py::array::c_style | py::array::forcecast>(array_);
}

Eigen::Map<const FeatureMatrix, 0, Eigen::OuterStride<>> FeatureRows::matrix() const {
  // An array of one row may have any stride; the map wants one that holds the row.
  const auto stride =
      std::max<py::ssize_t>(array_.strides(0) / static_cast<py::ssize_t>(sizeof(float)), array_.shape(1));
  return {array_.data(), array_.shape(0), array_.shape(1), Eigen::OuterStride<>(stride)};
}

std::vector<cv::Point2f> points_argument(const py::object& value, const char* name) {
  const std::string expected = "a float32 array of shape (N, 2)";
  const auto array = array_argument<float>(value, name, expected);
  if (array.ndim() != 2 || array.shape(1) != 2) wrong_value(name, expected, value);
  const auto values = array.unchecked<2>();
  std::vector<cv::Point2f> points;
  points.reserve(static_cast<std::size_t>(values.shape(0)));
  for (py::ssize_t i = 0; i < values.shape(0); ++i) points.emplace_back(values(i, 0), values(i, 1));
  return points;
}

std::vector<float> floats_argument(const py::object& value, const char* name) {
  if (value.is_none()) return {};
  const std::string expected = "a float32 array of shape (N,)";
  const auto array = array_argument<float>(value, name, expected);
  if (array.ndim() != 1) wrong_value(name, expected, value);
  const auto values = array.unchecked<1>();
  std::vector<float> result(static_cast<std::size_t>(values.shape(0)));
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = values(static_cast<py::ssize_t>(i));
  return result;
}

std::vector<int> integers_argument(const py::object& value, const char* name) {
  const std::string expected = "an integer array of shape (M,)";
  if (!py::isinstance<py::array>(value)) wrong_type(name, expected, value);
  const auto array = py::reinterpret_borrow<py::array>(value);
  const char kind = array.dtype().kind();
  if (kind != 'i' && kind != 'u' && kind != 'b') wrong_type(name, expected, value);
  if (array.ndim() != 1) wrong_value(name, expected, value);
  const py::array_t<std::int64_t, py::array::forcecast> wide(array);
  const auto values = wide.unchecked<1>();
  std::vector<int> result;
  result.reserve(static_cast<std::size_t>(values.shape(0)));
  for (py::ssize_t i = 0; i < values.shape(0); ++i) {
    if (values(i) < INT32_MIN || values(i) > INT32_MAX) {
      throw py::value_error(std::string(name) + ": expected 32-bit integers, got " +
                            std::to_string(values(i)));
    }
    result.push_back(static_cast<int>(values(i)));
  }
  return result;
}

py::array_t<double, py::array::c_style> vectors_argument(const py::object& value, int width,
                                                         const char* name) {
  const std::string expected = "real numbers of shape (..., " + std::to_string(width) + ")";
  const py::array array = py::array::ensure(value);
  if (!array) {
    PyErr_Clear();
    wrong_type(name, expected, value);
  }
  const char kind = array.dtype().kind();
  if (kind != 'i' && kind != 'u' && kind != 'f') wrong_type(name, expected, array);
  if (array.ndim() < 1 || array.shape(array.ndim() - 1) != width) wrong_value(name, expected, array);
  return py::array_t<double, py::array::c_style | py::array::forcecast>(array);
}

Eigen::VectorXd doubles_argument(const py::object& value, const char* name) {
  const std::string expected = "a float64 array of shape (M,)";
  const auto array = array_argument<double>(value, name, expected);
  if (array.ndim() != 1) wrong_value(name, expected, value);
  const auto values = array.unchecked<1>();
  Eigen::VectorXd result(values.shape(0));
  for (py::ssize_t i = 0; i < values.shape(0); ++i) result[i] = values(i);
  return result;
}

void own(cv::Mat& matrix) {
  if (!matrix.empty() && matrix.u == nullptr) matrix = matrix.clone();
}

Layout layout(const FeatureMatrix& matrix) {
  constexpr auto scalar = static_cast<py::ssize_t>(sizeof(float));
  return {matrix.data(), {matrix.rows(), matrix.cols()}, {matrix.cols() * scalar, scalar}};
}
Layout layout(const Eigen::VectorXd& vector) {
  return vector_layout(vector.data(), static_cast<std::size_t>(vector.size()));
}
Layout layout(const Eigen::VectorXf& vector) {
  return vector_layout(vector.data(), static_cast<std::size_t>(vector.size()));
}
Layout layout(const std::vector<cv::Point2f>& points) {
  return point_layout(points);
}
Layout layout(const std::vector<cv::Point>& points) {
  return point_layout(points);
}
Layout layout(const std::vector<float>& values) {
  return vector_layout(values.data(), values.size());
}
Layout layout(const std::vector<int>& values) {
  return vector_layout(values.data(), values.size());
}

Layout layout(const cv::Mat& matrix) {
  if (matrix.empty()) return {nullptr, {0, 0}, {0, 0}};
  Layout l{matrix.data,
           {matrix.rows, matrix.cols},
           {static_cast<py::ssize_t>(matrix.step[0]), static_cast<py::ssize_t>(matrix.elemSize())}};
  if (matrix.channels() > 1) {
    l.shape.push_back(matrix.channels());
    l.strides.push_back(static_cast<py::ssize_t>(matrix.elemSize1()));
  }
  return l;
}

py::array_t<std::uint8_t> image_result(const cv::Mat& image) {
  cv::Mat result;
  if (image.channels() == 3) {
    cv::cvtColor(image, result, cv::COLOR_BGR2RGB);
  } else {
    result = image.clone();
  }
  return moved<std::uint8_t>(std::move(result));
}

}  // namespace graspctx::python
