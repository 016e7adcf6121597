#include <opencv2/core.hpp>

#include "bind.hpp"
#include "graspctx/error.hpp"
#include "graspctx/version.hpp"

PYBIND11_MODULE(_core, m) {
  namespace py = pybind11;
  using namespace graspctx::python;

  m.doc() = "Grasp configurations from a stereo pair: the bindings of the C++ library.";
  m.attr("__version__") = graspctx::version;

  py::register_exception<graspctx::InvalidInput>(m, "InvalidInput", PyExc_ValueError).doc() =
      "Input that cannot be used: a missing or invalid file, an image of the wrong size, an option out of "
      "range.";
  py::register_exception_translator([](std::exception_ptr error) {
    try {
      if (error) std::rethrow_exception(error);
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
}
