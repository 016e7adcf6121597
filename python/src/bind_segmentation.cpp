#include <pybind11/stl.h>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/segmentation.hpp"
#include "options.hpp"

namespace graspctx::python {

namespace {

/// From a raw or rectified pair to its segmentation, as detect_grasps does it.
Segmentation segment(const std::string& function, const py::object& left, const py::object& right,
                     const StereoCamera& camera, const py::kwargs& arguments) {
  SegmentationOptions segmentation;
  DisparityOptions disparity;
  read_keywords(function, arguments, all_keywords(segmentation, disparity));
  const cv::Mat left_image = image_argument(left, "left"), right_image = image_argument(right, "right");
  return without_gil([&] {
    const RectifiedPair pair = rectify(left_image, right_image, camera);
    return segment_objects(pair, compute_disparity(pair, disparity), camera, segmentation);
  });
}

}  // namespace

void bind_segmentation(py::module_& m) {
  py::class_<TablePlane> plane(m, "TablePlane", R"(The supporting plane.

In the image d = alpha·u + beta·v + delta_px (III-A); in the camera frame normal·P + offset_m is the height (m)
above it.)");
  plane.def_readonly("alpha", &TablePlane::alpha);
  plane.def_readonly("beta", &TablePlane::beta);
  plane.def_readonly("delta_px", &TablePlane::delta_px);
  def_vector(plane, "normal", &TablePlane::normal, "(3,) unit, from the plane to the camera.");
  plane.def_readonly("offset_m", &TablePlane::offset_m, "The camera's height above the plane.");
  plane.def_readonly("sigma_px", &TablePlane::sigma_px,
                     "Robust deviation of the disparities from the plane.");

  py::class_<ObjectHypothesis> hypothesis(m, "ObjectHypothesis", "An object of a Segmentation.");
  hypothesis.def_readonly("id", &ObjectHypothesis::id, "Its value in Segmentation.instance_ids.");
  hypothesis.def_property_readonly(
      "bounding_box_px",
      [](const ObjectHypothesis& self) {
        const cv::Rect& box = self.bounding_box_px;
        return std::tuple(box.x, box.y, box.width, box.height);
      },
      "x, y, width, height.");
  def_vector(hypothesis, "centroid_px", &ObjectHypothesis::centroid_px, "(2,) u, v.");
  hypothesis.def_readonly("saliency", &ObjectHypothesis::saliency, "The hypotheses are ordered by it.");
  hypothesis.def_readonly("touches_border", &ObjectHypothesis::touches_border);

  py::class_<Segmentation> segmentation(m, "Segmentation", "The objects of a scene and what they stand on.");
  def_array<std::uint8_t>(segmentation, "instance_ids", &Segmentation::instance_ids,
                          "(H, W) uint8, 0 = background, otherwise ObjectHypothesis.id.");
  segmentation.def_readonly("table", &Segmentation::table, "TablePlane, or None.");
  segmentation.def_readonly("objects", &Segmentation::objects, "The most salient first.");
  segmentation.def_readonly("warnings", &Segmentation::warnings);

  SegmentationOptions defaults;
  DisparityOptions disparity_defaults;
  const std::string arguments = "left: " + image_type + ", right: " + image_type + ", camera: StereoCamera";
  const Keywords options = all_keywords(defaults, disparity_defaults);
  define(
      m, "segment_objects", signature(arguments, options, image_type),
      R"(Find the objects of a scene without knowing what they are: (H, W) uint8 instance ids, 0 = background (III-A).

left, right: uint8 images, RGB (H, W, 3) or grey (H, W), rectified first if camera.raw says how.
cues: 'disparity', 'plane' or 'colour'; each adds to the one before (Fig. 2).
fixation_px: (u, v), look only at the object at this pixel of the left view.
No object is an answer. Raises InvalidInput for unusable images or options.)",
      [](const py::object& left, const py::object& right, const StereoCamera& camera,
         const py::kwargs& keyword_arguments) {
        return moved<std::uint8_t>(
            segment("segment_objects", left, right, camera, keyword_arguments).instance_ids);
      },
      py::arg("left"), py::arg("right"), py::arg("camera"));
  define(
      m, "segment_scene", signature(arguments, options, "Segmentation"),
      "As segment_objects, with the table plane, each object's hypothesis and warnings.",
      [](const py::object& left, const py::object& right, const StereoCamera& camera,
         const py::kwargs& keyword_arguments) {
        return segment("segment_scene", left, right, camera, keyword_arguments);
      },
      py::arg("left"), py::arg("right"), py::arg("camera"));
}

}  // namespace graspctx::python
