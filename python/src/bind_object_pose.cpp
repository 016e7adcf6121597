#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/object_pose.hpp"

namespace graspctx::python {

void bind_object_pose(py::module_& m) {
  py::class_<ObjectPose> pose(m, "ObjectPose",
                              "A rough object pose (III-D): the plane through three matched points.");
  def_vector(pose, "centroid_m", &ObjectPose::centroid_m, "(3,) camera frame.");
  def_vector(pose, "major_axis_m", &ObjectPose::major_axis_m, "(3,) a_ma, from the centroid.");
  def_vector(pose, "minor_axis_m", &ObjectPose::minor_axis_m, "(3,) a_mi, from the centroid.");
  def_vector(pose, "normal", &ObjectPose::normal, "(3,) n_p, unit, towards the camera.");
  def_vector(pose, "centroid_px", &ObjectPose::centroid_px, "(2,) left image.");
  def_vector(pose, "major_px", &ObjectPose::major_px, "(2,) left image.");
  def_vector(pose, "minor_px", &ObjectPose::minor_px, "(2,) left image.");
  pose.def_property_readonly(
      "source",
      [](const ObjectPose& self) {
        return self.source == ObjectPose::Source::stereo ? "stereo" : "segment_depth";
      },
      "'stereo', or 'segment_depth' if some point matched badly.");
}

}  // namespace graspctx::python
