#include <pybind11/stl.h>

#include <map>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/io/picture.hpp"
#include "graspctx/segmentation.hpp"
#include "options.hpp"

namespace graspctx::python {

namespace {

/// What the segmentation of a raw or rectified pair starts from, as in detect_grasps.
struct SegmentationInput {
  RectifiedPair pair;
  Disparity disparity;
  SegmentationOptions options;
};

SegmentationInput segmentation_input(const std::string& function, const py::object& left,
                                     const py::object& right, const StereoCamera& camera,
                                     const py::kwargs& arguments) {
  SegmentationInput input;
  DisparityOptions disparity;
  read_keywords(function, arguments, all_keywords(input.options, disparity));
  const cv::Mat left_image = image_argument(left, "left"), right_image = image_argument(right, "right");
  without_gil([&] {
    input.pair = rectify(left_image, right_image, camera);
    input.disparity = compute_disparity(input.pair, disparity);
  });
  return input;
}

Segmentation segment(const std::string& function, const py::object& left, const py::object& right,
                     const StereoCamera& camera, const py::kwargs& arguments) {
  const SegmentationInput input = segmentation_input(function, left, right, camera, arguments);
  return without_gil([&] { return segment_objects(input.pair, input.disparity, camera, input.options); });
}

cv::Mat draw(const SegmentationInput& input, const StereoCamera& camera, int panel_px) {
  std::map<CueLevel, Segmentation> levels;
  for (const CueLevel level : {CueLevel::disparity, CueLevel::plane, CueLevel::colour}) {
    SegmentationOptions options = input.options;
    options.cues = level;
    levels[level] = segment_objects(input.pair, input.disparity, camera, options);
  }
  return draw_segmentation(input.pair.left, input.disparity, camera, levels, input.options, panel_px);
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
  hypothesis.def_readonly("saliency", &ObjectHypothesis::saliency,
                          "The area surely seen (cm²) over the distance (m); the hypotheses are ordered by "
                          "it. Of a caller's own mask: its pixels.");
  hypothesis.def_readonly("touches_border", &ObjectHypothesis::touches_border, "It is cut by the image.");
  hypothesis.def_readonly("leaves_table", &ObjectHypothesis::leaves_table,
                          "Part of it stands or hangs beyond the table's edge. False without a plane.");
  hypothesis.def_property_readonly(
      "size_m",
      [](const ObjectHypothesis& self) -> std::optional<py::array_t<double>> {
        if (!self.size_m) return std::nullopt;
        return copied(*self.size_m);
      },
      "(3,) length and width of what is seen of it from above, height over the table; None where unknown.");
  hypothesis.def_readonly("depth_m", &ObjectHypothesis::depth_m,
                          "Median over its pixels, along the viewing axis; None where unknown.");

  py::class_<Segmentation> segmentation(m, "Segmentation", "The objects of a scene and what they stand on.");
  def_array<std::uint8_t>(segmentation, "instance_ids", &Segmentation::instance_ids,
                          "(H, W) uint8, 0 = background, otherwise ObjectHypothesis.id.");
  segmentation.def_readonly("table", &Segmentation::table, "TablePlane, or None.");
  segmentation.def_property_readonly(
      "heights_m",
      [](const py::object& self) -> std::optional<py::array_t<float>> {
        const cv::Mat& heights_m = self.cast<const Segmentation&>().heights_m;
        if (heights_m.empty()) return std::nullopt;
        return viewed<float>(heights_m, self);
      },
      "(H, W) float32 heights above the table, NaN where unknown; None without a table.");
  segmentation.def_readonly("objects", &Segmentation::objects, "The most salient first.");
  segmentation.def_readonly(
      "vertical_offset_px", &Segmentation::vertical_offset_px,
      "How much lower the scene lies in the right view than in the left one, about 0 in "
      "a rectified pair; None if it cannot be measured.");
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
fixation_px: (u, v), look only at the object at this pixel of the left view. roi_px: (x, y, width, height), only
at the object in this box.
table: the known plane of a fixed rig, a TablePlane or (nx, ny, nz, offset_m) with a unit normal towards the
camera. gravity: (x, y, z) where things fall, in the camera frame, for cameras that are not upright.
No object is an answer. Raises InvalidInput for unusable images or options.)",
      [](const py::object& left, const py::object& right, const StereoCamera& camera,
         const py::kwargs& keyword_arguments) {
        return moved<std::uint8_t>(
            segment("segment_objects", left, right, camera, keyword_arguments).instance_ids);
      },
      py::arg("left"), py::arg("right"), py::arg("camera"));
  define(
      m, "draw_segmentation", signature(arguments + ", *, panel_px: int = 640", options, image_type),
      R"(A picture that explains how a scene is segmented (Fig. 2): uint8 RGB.

Eight panels, the longer side of each panel_px: the hypotheses of the level cues, the disparity, a grid on the table
plane, the heights above it, the three cue levels side by side, and the objects in numbers. The arguments and
options are those of segment_objects. Raises InvalidInput for unusable images or options.)",
      [](const py::object& left, const py::object& right, const StereoCamera& camera, int panel_px,
         const py::kwargs& keyword_arguments) {
        const SegmentationInput input =
            segmentation_input("draw_segmentation", left, right, camera, keyword_arguments);
        return image_result(without_gil([&] { return draw(input, camera, panel_px); }));
      },
      py::arg("left"), py::arg("right"), py::arg("camera"), py::kw_only(), py::arg("panel_px") = 640);
  define(
      m, "segment_scene", signature(arguments, options, "Segmentation"),
      "As segment_objects, with the table plane, the heights above it, each object's hypothesis and "
      "warnings.",
      [](const py::object& left, const py::object& right, const StereoCamera& camera,
         const py::kwargs& keyword_arguments) {
        return segment("segment_scene", left, right, camera, keyword_arguments);
      },
      py::arg("left"), py::arg("right"), py::arg("camera"));
}

}  // namespace graspctx::python
