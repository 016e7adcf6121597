#pragma once
#include <pybind11/pybind11.h>

#include <utility>
#include <vector>

#include "graspctx/detector.hpp"
#include "graspctx/io/model_file.hpp"

/// One function for each stage, in the order of the data.
namespace graspctx::python {

namespace py = pybind11;

/// A detection knows what it came from, for its JSON and its picture.
struct DetectionResult {
  Detection detection;
  StereoCamera camera;
  std::string model_name, model_sha256;
};

void bind_image_file(py::module_& m);
void bind_camera(py::module_& m);
void bind_stereo(py::module_& m);
void bind_segmentation(py::module_& m);
void bind_fovea(py::module_& m);
void bind_contour(py::module_& m);
void bind_shape_context(py::module_& m);
void bind_patch_descriptor(py::module_& m);
void bind_grasp_model(py::module_& m);
void bind_grasp_points(py::module_& m);
void bind_object_pose(py::module_& m);
void bind_grasp(py::module_& m);
void bind_detector(py::module_& m);
void bind_dataset(py::module_& m);
void bind_evaluation(py::module_& m);
void bind_explanation(py::module_& m);

/// Run something long while other Python threads go on.
template <typename Function>
auto without_gil(Function&& function) {
  const py::gil_scoped_release release;
  return std::forward<Function>(function)();
}

/// A GraspModel or a sequence of them; the caller keeps `value` alive.
std::vector<const LoadedModel*> models_argument(const py::object& value, const char* name);

/// The hash of the file that holds the model, or would hold it.
std::string model_sha256(const LoadedModel& model);

}  // namespace graspctx::python
