#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "graspctx/shape_context.hpp"

/// Between numpy arrays and the types of the core. Arguments of a wrong type raise TypeError, of a wrong
/// shape ValueError; both name what came and what was expected.
namespace graspctx::python {

namespace py = pybind11;

/// "uint8 array of shape (480, 640)", or the name of another type.
std::string describe(py::handle value);

// ---- Arguments: the caller keeps `value` alive while the result is in use
// ----------------------------------

/// uint8 (H, W, 3) RGB or (H, W) grey, as CV_8UC3 BGR or CV_8UC1. Grey is not copied if its rows are
/// contiguous.
cv::Mat image_argument(const py::object& value, const char* name);
/// uint8 or bool (H, W), not copied if its rows are contiguous; None gives an empty mask.
cv::Mat mask_argument(const py::object& value, const char* name);

/// float32 (M, D) rows of features, not copied if each row is contiguous.
class FeatureRows {
 public:
  FeatureRows(const py::object& value, const char* name);
  Eigen::Map<const FeatureMatrix, 0, Eigen::OuterStride<>> matrix() const;

 private:
  py::array_t<float> array_;
};

/// float32 (N, 2) pixels.
std::vector<cv::Point2f> points_argument(const py::object& value, const char* name);
/// float32 (N); None gives none.
std::vector<float> floats_argument(const py::object& value, const char* name);
/// (M) of any integer type or bool.
std::vector<int> integers_argument(const py::object& value, const char* name);
/// Any real numbers of shape (..., width), as float64.
py::array_t<double, py::array::c_style> vectors_argument(const py::object& value, int width,
                                                         const char* name);
/// float64 (M).
Eigen::VectorXd doubles_argument(const py::object& value, const char* name);

/// A matrix that lies in somebody else's memory is copied: results may outlive the arguments.
void own(cv::Mat& matrix);

// ---- Results ----------------------------------------------------------------------------------------------

/// How a container of the core is laid out as an array.
struct Layout {
  const void* data;
  std::vector<py::ssize_t> shape, strides;
};
Layout layout(const FeatureMatrix& matrix);
Layout layout(const Eigen::VectorXd& vector);
Layout layout(const Eigen::VectorXf& vector);
Layout layout(const std::vector<cv::Point2f>& points);
Layout layout(const std::vector<cv::Point>& points);
Layout layout(const std::vector<float>& values);
Layout layout(const std::vector<int>& values);
Layout layout(const cv::Mat& matrix);

/// The container moved into an array, without copying its contents.
template <typename Scalar, typename Container>
py::array_t<Scalar> moved(Container container) {
  auto owner = std::make_unique<Container>(std::move(container));
  const Layout l = layout(*owner);
  const py::capsule capsule(owner.get(), [](void* memory) { delete static_cast<Container*>(memory); });
  owner.release();
  return py::array_t<Scalar>(l.shape, l.strides, static_cast<const Scalar*>(l.data), capsule);
}

/// A read-only array over a member of `parent`, which it keeps alive.
template <typename Scalar, typename Container>
py::array_t<Scalar> viewed(const Container& container, const py::object& parent) {
  const Layout l = layout(container);
  py::array_t<Scalar> array(l.shape, l.strides, static_cast<const Scalar*>(l.data), parent);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// A read-only property over a container: def_array<float>(class_, "points", &Contour::points, "…").
template <typename Scalar, typename Class, typename Struct, typename Container>
void def_array(Class& class_, const char* name, Container Struct::*member, const char* doc) {
  class_.def_property_readonly(
      name,
      [member](const py::object& self) { return viewed<Scalar>(self.cast<const Struct&>().*member, self); },
      doc);
}

/// A small vector or matrix as a new array.
template <typename Derived>
py::array_t<double> copied(const Eigen::MatrixBase<Derived>& matrix) {
  std::vector<py::ssize_t> shape{matrix.rows()};
  if (matrix.cols() != 1) shape.push_back(matrix.cols());
  py::array_t<double> array(shape);
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      array.mutable_data()[row * matrix.cols() + column] = matrix(row, column);
    }
  }
  return array;
}

/// A property that copies a small vector or matrix.
template <typename Class, typename Struct, typename Matrix>
void def_vector(Class& class_, const char* name, Matrix Struct::*member, const char* doc) {
  class_.def_property_readonly(
      name, [member](const Struct& self) { return copied(self.*member); }, doc);
}

/// A BGR or grey image as a new RGB or grey array.
py::array_t<std::uint8_t> image_result(const cv::Mat& image);

}  // namespace graspctx::python
