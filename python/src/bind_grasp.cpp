#include <pybind11/stl.h>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/grasp.hpp"

namespace graspctx::python {

void bind_grasp(py::module_& m) {
  py::class_<GraspConfiguration> grasp(m, "GraspConfiguration",
                                       R"(A full grasp configuration in the camera frame.

Hand frame: z = approach (palm towards the object), x = closing (from thumb to fingers), y = z × x; origin at the
grasp point, between the pads.)");
  grasp.def_readonly("rank", &GraspConfiguration::rank, "From 1, in its object.");
  grasp.def_readonly("patch", &GraspConfiguration::patch,
                     "Of the left foveal view: its row in ObjectIntermediates.patches.");
  grasp.def_readonly("probability", &GraspConfiguration::probability, "Eq. 1: left · right.");
  grasp.def_readonly("probability_left", &GraspConfiguration::probability_left);
  grasp.def_readonly("probability_right", &GraspConfiguration::probability_right);
  def_vector(grasp, "left_px", &GraspConfiguration::left_px, "(2,) u, v.");
  def_vector(grasp, "right_px", &GraspConfiguration::right_px, "(2,) u, v.");
  def_vector(grasp, "position_m", &GraspConfiguration::position_m, "(3,) the grasp point.");
  def_vector(grasp, "position_stddev_m", &GraspConfiguration::position_stddev_m, "(3,)");
  grasp.def_property_readonly(
      "rule", [](const GraspConfiguration& self) { return name_of(self.rule); },
      "'plane_normal', 'major_axis' or 'minor_axis' (Eq. 3).");
  def_vector(grasp, "approach", &GraspConfiguration::approach, "(3,) unit, from the palm to the object.");
  def_vector(grasp, "closing", &GraspConfiguration::closing, "(3,) unit, from thumb to fingers.");
  def_vector(grasp, "cam_from_hand", &GraspConfiguration::cam_from_hand, "(4, 4)");
  grasp.def_readonly("opening_m", &GraspConfiguration::opening_m, "Between the pads before they close.");
  grasp.def_readonly("feasible", &GraspConfiguration::feasible);
  grasp.def_readonly("infeasible_because", &GraspConfiguration::infeasible_because, "Why, or None.");
  grasp.def("__repr__", [](const GraspConfiguration& self) {
    return py::str(
               "GraspConfiguration(rank={}, probability={:.3f}, position_m=({:.4f}, {:.4f}, {:.4f}), "
               "rule={!r}{})")
        .format(self.rank, self.probability, self.position_m.x(), self.position_m.y(), self.position_m.z(),
                name_of(self.rule), self.feasible ? "" : ", infeasible");
  });
}

}  // namespace graspctx::python
