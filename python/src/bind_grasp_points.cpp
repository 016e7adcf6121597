#include <pybind11/stl.h>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/grasp_points.hpp"
#include "options.hpp"

namespace graspctx::python {

void bind_grasp_points(py::module_& m) {
  py::class_<GraspPoint>(m, "GraspPoint", "A local maximum of the response in one view.")
      .def_readonly("patch", &GraspPoint::patch, "Row in the PatchDescriptors.")
      .def_property_readonly(
          "centre_px",
          [](const GraspPoint& self) { return copied(Eigen::Vector2d(self.centre_px.x, self.centre_px.y)); },
          "(2,) u, v of the view.")
      .def_readonly("probability", &GraspPoint::probability, "P(g = 1 | D) in this view.");

  GraspPointOptions defaults;
  define(
      m, "find_grasp_points",
      signature("patches: PatchDescriptors, probabilities: " + float64_type, keywords(defaults),
                "list[GraspPoint]"),
      R"(Patches that are local maxima of the response and whose neighbours carry values close to theirs (III-D, IV).

probabilities: float64 (M,) of the patches. The highest first. neighbour_ratio: mean of the neighbours, as a
share of the centre's value.)",
      [](const PatchDescriptors& patches, const py::object& probabilities, const py::kwargs& arguments) {
        GraspPointOptions options;
        read_keywords("find_grasp_points", arguments, keywords(options));
        const Eigen::VectorXd values = doubles_argument(probabilities, "probabilities");
        return without_gil([&] { return find_grasp_points(patches, values, options); });
      },
      py::arg("patches"), py::arg("probabilities"));
}

}  // namespace graspctx::python
