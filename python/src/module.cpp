#include <opencv2/core.hpp>

#include "bind.hpp"
#include "graspctx/error.hpp"
#include "graspctx/version.hpp"

PYBIND11_MODULE(_core, m) {
  namespace py = pybind11;
  using namespace graspctx::python;

  m.doc() = "Grasp configurations from a stereo pair: the bindings of the C++ library.";
  m.attr("__version__") = graspctx::version;

  static PyObject* invalid_input = nullptr;  // the module keeps it alive
  auto exception_type = py::register_exception<graspctx::InvalidInput>(m, "InvalidInput", PyExc_ValueError);
  exception_type.doc() =
      "Input that cannot be used: a missing or invalid file, an image of the wrong size, an option out of "
      "range.";
  invalid_input = exception_type.ptr();
  py::register_exception_translator([](std::exception_ptr error) {
    try {
      if (error) std::rethrow_exception(error);
    } catch (const graspctx::InvalidInput& exception) {
      // It may quote a file's name, whose bytes need not be UTF-8.
      const std::string message = exception.what();
      const auto text = py::reinterpret_steal<py::object>(
          PyUnicode_DecodeUTF8(message.data(), static_cast<py::ssize_t>(message.size()), "backslashreplace"));
      if (text) PyErr_SetObject(invalid_input, text.ptr());
    } catch (const cv::Exception& exception) {
      py::set_error(PyExc_RuntimeError, ("OpenCV: " + exception.msg).c_str());
    }
  });

  // In the order of the data; a class comes before the functions that name it.
  bind_image_file(m);
  bind_camera(m);
  bind_stereo(m);
  bind_segmentation(m);
  bind_fovea(m);
  bind_contour(m);
  bind_shape_context(m);
  bind_patch_descriptor(m);
  bind_grasp_model(m);
  bind_grasp_points(m);
  bind_object_pose(m);
  bind_grasp(m);
  bind_detector(m);
  bind_dataset(m);
  bind_evaluation(m);
  bind_explanation(m);
}
