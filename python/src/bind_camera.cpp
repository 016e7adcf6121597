#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/camera.hpp"
#include "graspctx/error.hpp"
#include "graspctx/io/calibration_file.hpp"
#include "options.hpp"

namespace graspctx::python {

namespace {

using Doubles = py::array_t<double, py::array::c_style>;

/// Apply a function to each vector of the last axis: (..., width_in) → (..., width_out).
template <int width_in, int width_out, typename Function>
py::array_t<double> for_each_vector(const Doubles& vectors, const Function& function) {
  std::vector<py::ssize_t> shape(vectors.shape(), vectors.shape() + vectors.ndim());
  shape.back() = width_out;
  py::array_t<double> result(shape);
  const double* from = vectors.data();
  double* to = result.mutable_data();
  for (py::ssize_t i = 0; i < vectors.size() / width_in; ++i) {
    using In = Eigen::Matrix<double, width_in, 1>;
    using Out = Eigen::Matrix<double, width_out, 1>;
    Eigen::Map<Out>(to + i * width_out) = function(In(Eigen::Map<const In>(from + i * width_in)));
  }
  return result;
}

/// Disparities for pixels of shape (..., 2): one for all, or of shape (...).
Doubles disparities_argument(const py::object& value, const Doubles& pixels) {
  const Doubles columns =
      vectors_argument(py::module_::import("numpy").attr("expand_dims")(value, -1), 1, "disparity_px");
  const auto leading = static_cast<std::size_t>(pixels.ndim() - 1);
  const bool same = columns.ndim() == pixels.ndim() &&
                    std::equal(columns.shape(), columns.shape() + leading, pixels.shape());
  if (columns.size() != 1 && !same) {
    throw py::value_error("disparity_px: expected one number, or one for each pixel of left_px, got " +
                          describe(py::array(value)));
  }
  return columns;
}

Eigen::Matrix3d matrix_argument(const py::object& value, const char* name) {
  const Doubles rows = vectors_argument(value, 3, name);
  if (rows.ndim() != 2 || rows.shape(0) != 3) {
    throw py::value_error(std::string(name) + ": expected real numbers of shape (3, 3), got " +
                          describe(rows));
  }
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
}

RawView::Distortion distortion_model(const std::string& name) {
  if (name == "plumb_bob") return RawView::Distortion::plumb_bob;
  if (name == "equidistant") return RawView::Distortion::equidistant;
  throw py::value_error("distortion_model: expected 'plumb_bob' or 'equidistant', got '" + name + "'");
}

const char* distortion_name(const RawView& view) {
  return view.distortion_model == RawView::Distortion::plumb_bob ? "plumb_bob" : "equidistant";
}

template <typename Value>
std::string repr(const Value& value) {
  return py::repr(py::cast(value)).template cast<std::string>();
}

/// For pickle: the class called with its own properties as keyword arguments.
py::tuple reduced(const py::object& self, const std::vector<const char*>& properties) {
  py::dict arguments;
  for (const char* name : properties) arguments[name] = self.attr(name);
  const py::object partial = py::module_::import("functools").attr("partial");
  return py::make_tuple(partial(py::type::of(self), **arguments), py::tuple());
}

void bind_raw_view(py::module_& m) {
  py::class_<RawView> raw_view(m, "RawView",
                               "How one raw (unrectified, distorted) view becomes its rectified view.");
  const RawView defaults;
  define_init(
      raw_view,
      "(self: RawView, *, camera_matrix: numpy.typing.ArrayLike, rectified_from_raw: numpy.typing.ArrayLike, "
      "distortion_model: str = " +
          repr(distortion_name(defaults)) + ", distortion: collections.abc.Sequence[float] = ()) -> None",
      "camera_matrix, rectified_from_raw: (3, 3). distortion_model: 'plumb_bob' (0, 4, 5 or 8 coefficients) "
      "or "
      "'equidistant' (4).",
      py::init([](const py::object& camera_matrix, const py::object& rectified_from_raw,
                  const std::string& model, std::vector<double> distortion) {
        RawView view;
        view.camera_matrix = matrix_argument(camera_matrix, "camera_matrix");
        view.rectified_from_raw = matrix_argument(rectified_from_raw, "rectified_from_raw");
        view.distortion_model = distortion_model(model);
        view.distortion = std::move(distortion);
        return view;
      }),
      py::kw_only(), py::arg("camera_matrix"), py::arg("rectified_from_raw"),
      py::arg("distortion_model") = distortion_name(defaults), py::arg("distortion") = defaults.distortion);
  def_vector(raw_view, "camera_matrix", &RawView::camera_matrix, "(3, 3) raw intrinsics, px.");
  def_vector(raw_view, "rectified_from_raw", &RawView::rectified_from_raw, "(3, 3) rotation.");
  raw_view.def_property_readonly("distortion_model", &distortion_name, "'plumb_bob' or 'equidistant'.");
  raw_view.def_property_readonly(
      "distortion", [](const RawView& view) { return view.distortion; }, "The model's coefficients.");
  raw_view.def("__reduce__", [](const py::object& self) {
    return reduced(self, {"camera_matrix", "rectified_from_raw", "distortion_model", "distortion"});
  });
}

}  // namespace

void bind_camera(py::module_& m) {
  bind_raw_view(m);

  const StereoCamera defaults;
  py::class_<StereoCamera> camera(m, "StereoCamera", R"(A rectified stereo pair of pinhole cameras.

Left is the reference view. The camera frame is the left rectified optical frame: x right, y down, z forward,
metres. Pixel centres are at integers. Z = f · B / (d + doffs).)");
  define_init(
      camera,
      "(self: StereoCamera, *, focal_px: float, centre_px: numpy.typing.ArrayLike, baseline_m: float, "
      "doffs_px: float = " +
          repr(defaults.doffs_px) + ", width_px: int = " + repr(defaults.width_px) + ", height_px: int = " +
          repr(defaults.height_px) + ", raw: tuple[RawView, RawView] | None = None) -> None",
      R"(centre_px: (u, v), principal point of the left view. doffs_px: the right one's u minus the left one's.
width_px, height_px: 0 if unknown. raw: left and right, if the images still have to be rectified.
Raises InvalidInput if a number is out of range.)",
      py::init([](double focal_px, const py::object& centre_px, double baseline_m, double doffs_px,
                  int width_px, int height_px, std::optional<std::array<RawView, 2>> raw) {
        const Doubles centre = vectors_argument(centre_px, 2, "centre_px");
        if (centre.ndim() != 1)
          throw py::value_error("centre_px: expected one pixel, got " + describe(centre));
        StereoCamera result;
        result.focal_px = focal_px;
        result.centre_px = {centre.data()[0], centre.data()[1]};
        result.baseline_m = baseline_m;
        result.doffs_px = doffs_px;
        result.width_px = width_px;
        result.height_px = height_px;
        result.raw = std::move(raw);
        result.check();
        return result;
      }),
      py::kw_only(), py::arg("focal_px"), py::arg("centre_px"), py::arg("baseline_m"),
      py::arg("doffs_px") = defaults.doffs_px, py::arg("width_px") = defaults.width_px,
      py::arg("height_px") = defaults.height_px, py::arg("raw") = py::none());
  camera.def_static(
      "load",
      [](const std::filesystem::path& path, const std::optional<std::filesystem::path>& path2,
         bool rectified) {
        std::vector<std::filesystem::path> files{path};
        if (path2) files.push_back(*path2);
        return load_calibration(files, rectified);
      },
      py::arg("path"), py::arg("path2") = py::none(), py::arg("rectified") = false,
      "Load a Middlebury calib.txt, or a pair of ROS camera_info YAML files (left, right). rectified says "
      "that "
      "the images of a camera_info pair are rectified already. Raises InvalidInput naming the file.");
  camera.def_readonly("focal_px", &StereoCamera::focal_px, "Of both rectified views.");
  def_vector(camera, "centre_px", &StereoCamera::centre_px, "(2,) principal point of the left view (u, v).");
  camera.def_readonly("baseline_m", &StereoCamera::baseline_m);
  camera.def_readonly("doffs_px", &StereoCamera::doffs_px);
  camera.def_readonly("width_px", &StereoCamera::width_px, "Of the images; 0 if unknown.");
  camera.def_readonly("height_px", &StereoCamera::height_px, "Of the images; 0 if unknown.");
  camera.def_property_readonly(
      "raw",
      [](const StereoCamera& self) -> std::optional<std::tuple<RawView, RawView>> {
        if (!self.raw) return std::nullopt;
        return std::tuple((*self.raw)[0], (*self.raw)[1]);
      },
      "The left and the right RawView if the images still have to be rectified, else None.");

  const std::string self = "(self: StereoCamera, ";
  camera.def("depth_m", py::vectorize(&StereoCamera::depth_m), py::arg("disparity_px"),
             "Depth (m) of disparities (px) of any shape. Infinity where disparity + doffs <= 0.");
  camera.def("disparity_px", py::vectorize(&StereoCamera::disparity_px), py::arg("depth_m"),
             "Disparity (px) of depths (m) of any shape.");
  define(
      camera, "triangulate",
      self + "left_px: numpy.typing.ArrayLike, disparity_px: numpy.typing.ArrayLike) -> " + float64_type,
      "The points (..., 3) (m) seen at pixels (..., 2) of the left view with disparities (...) (px).",
      [](const StereoCamera& self_, const py::object& left_px, const py::object& disparity_px) {
        const Doubles pixels = vectors_argument(left_px, 2, "left_px");
        const Doubles disparities = disparities_argument(disparity_px, pixels);
        py::ssize_t i = 0;
        return for_each_vector<2, 3>(pixels, [&](const Eigen::Vector2d& px) {
          return self_.triangulate(px, disparities.data()[disparities.size() == 1 ? 0 : i++]);
        });
      },
      py::arg("left_px"), py::arg("disparity_px"));
  define(
      camera, "ray", self + "left_px: numpy.typing.ArrayLike) -> " + float64_type,
      "Unit viewing rays (..., 3) through pixels (..., 2) of the left view.",
      [](const StereoCamera& self_, const py::object& left_px) {
        return for_each_vector<2, 3>(vectors_argument(left_px, 2, "left_px"),
                                     [&](const Eigen::Vector2d& px) { return self_.ray(px); });
      },
      py::arg("left_px"));
  define(
      camera, "project", self + "point_m: numpy.typing.ArrayLike) -> " + float64_type,
      "Pixels (..., 2) of the left view where points (..., 3) (m, z > 0) are seen.",
      [](const StereoCamera& self_, const py::object& point_m) {
        return for_each_vector<3, 2>(vectors_argument(point_m, 3, "point_m"),
                                     [&](const Eigen::Vector3d& point) { return self_.project(point); });
      },
      py::arg("point_m"));
  camera.def("__reduce__", [](const py::object& self_) {
    return reduced(self_,
                   {"focal_px", "centre_px", "baseline_m", "doffs_px", "width_px", "height_px", "raw"});
  });
  camera.def("__repr__", [](const StereoCamera& self_) {
    return py::str(
               "StereoCamera(focal_px={!r}, centre_px=({!r}, {!r}), baseline_m={!r}, doffs_px={!r}, "
               "width_px={!r}, height_px={!r}{})")
        .format(self_.focal_px, self_.centre_px.x(), self_.centre_px.y(), self_.baseline_m, self_.doffs_px,
                self_.width_px, self_.height_px, self_.raw ? ", raw=(...)" : "");
  });
}

}  // namespace graspctx::python
