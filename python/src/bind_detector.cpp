#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/detector.hpp"
#include "graspctx/io/detection_json.hpp"
#include "graspctx/io/picture.hpp"
#include "options.hpp"

namespace graspctx::python {

namespace {

std::string to_json(const DetectionResult& self, std::optional<int> indent) {
  return without_gil([&] {
    return indent ? detection_to_json(self.detection, self.model_name, self.model_sha256, *indent)
                  : detection_to_json(self.detection, self.model_name, self.model_sha256);
  });
}

py::array_t<std::uint8_t> draw(const std::string& function, const DetectionResult& self,
                               const py::kwargs& arguments) {
  PictureOptions options;
  read_keywords(function, arguments, keywords(options));
  return image_result(without_gil([&] { return draw_detection(self.detection, self.camera, options); }));
}

/// A property of the detection inside a result.
template <typename Class, typename Value>
void def_detection_value(Class& class_, const char* name, Value Detection::*member, const char* doc) {
  class_.def_property_readonly(
      name, [member](const DetectionResult& self) -> const Value& { return self.detection.*member; },
      py::return_value_policy::reference_internal, doc);
}

void bind_detected_object(py::module_& m) {
  py::class_<ObjectIntermediates> seen(m, "ObjectIntermediates", "What was looked at on the way.");
  seen.def_readonly("fovea", &ObjectIntermediates::fovea);
  seen.def_readonly("contour", &ObjectIntermediates::contour, "Of the left foveal view.");
  seen.def_readonly("patches", &ObjectIntermediates::patches, "Of the left foveal view.");
  def_array<double>(seen, "probabilities", &ObjectIntermediates::probabilities,
                    "(M,) float64 P(g = 1 | D) of the patches.");

  py::class_<DetectedObject> object(m, "DetectedObject", "An object and the grasps it offers.");
  object.def_readonly("id", &DetectedObject::id, "Its value in Detection.segmentation.instance_ids.");
  object.def_property_readonly(
      "bounding_box_px",
      [](const DetectedObject& self) {
        const cv::Rect& box = self.bounding_box_px;
        return std::tuple(box.x, box.y, box.width, box.height);
      },
      "x, y, width, height.");
  def_vector(object, "centroid_px", &DetectedObject::centroid_px, "(2,) u, v.");
  object.def_readonly("pose", &DetectedObject::pose, "ObjectPose, or None.");
  object.def_readonly("grasps", &DetectedObject::grasps, "Feasible first, then by probability (Eq. 2).");
  object.def_readonly("model_name", &DetectedObject::model_name,
                      "The model that answers; '' if it cannot tell what is familiar.");
  object.def_readonly("familiarity", &DetectedObject::familiarity,
                      "0 to 1, of the object to that model; None if it cannot tell.");
  object.def_readonly("unfamiliar", &DetectedObject::unfamiliar, "To all models: it has no grasps.");
  object.def_readonly("intermediates", &DetectedObject::intermediates);
  object.def("__repr__", [](const DetectedObject& self) {
    return "DetectedObject(id=" + std::to_string(self.id) + ", " + std::to_string(self.grasps.size()) +
           " grasps)";
  });
}

}  // namespace

void bind_detector(py::module_& m) {
  bind_detected_object(m);

  PictureOptions picture_defaults;
  py::class_<DetectionResult> detection(m, "Detection", "What detect_grasps found, and what it looked at.");
  detection.def_property_readonly(
      "image_size",
      [](const DetectionResult& self) {
        return std::pair(self.detection.image_size.width, self.detection.image_size.height);
      },
      "Width and height of the rectified views.");
  def_detection_value(detection, "objects", &Detection::objects, "The one with the best grasp first.");
  def_detection_value(detection, "segmentation", &Detection::segmentation, "Instance ids, table plane.");
  detection.def_property_readonly(
      "disparity",
      [](const py::object& self) {
        return viewed<float>(self.cast<const DetectionResult&>().detection.disparity.dense, self);
      },
      "(H, W) float32 px, NaN where unknown: all that the matcher gave.");
  detection.def_property_readonly(
      "reliable_disparity",
      [](const py::object& self) {
        return viewed<float>(self.cast<const DetectionResult&>().detection.disparity.reliable, self);
      },
      "(H, W) float32 px, NaN where unknown: left-right consistent and textured.");
  detection.def_property_readonly(
      "left", [](const DetectionResult& self) { return image_result(self.detection.pair.left); },
      "The left rectified image, RGB or grey.");
  detection.def_property_readonly(
      "right", [](const DetectionResult& self) { return image_result(self.detection.pair.right); },
      "The right rectified image, RGB or grey.");
  def_detection_value(detection, "warnings", &Detection::warnings, "What to know about the result.");
  detection.def_property_readonly(
      "timings_ms",
      [](const DetectionResult& self) {
        py::typing::Dict<py::str, py::float_> timings;
        for (const auto& [stage, time_ms] : self.detection.timings_ms) timings[stage.c_str()] = time_ms;
        return timings;
      },
      "Stage and time, in order.");
  detection.def_readonly("camera", &DetectionResult::camera);
  detection.def_readonly("model_name", &DetectionResult::model_name);
  detection.def_readonly("model_sha256", &DetectionResult::model_sha256);
  detection.def("to_json", &to_json, py::arg("indent") = py::none(),
                "The detection as JSON, schema 1 (docs/detection-json.md). indent < 0: one line.");
  detection.def(
      "to_dict",
      [](const DetectionResult& self) -> py::typing::Dict<py::str, py::object> {
        return py::module_::import("json").attr("loads")(to_json(self, -1));
      },
      "The same as a dict of plain Python values.");
  const std::string doc =
      R"(Overlay of the left view: segments, contour, probabilities, hands in perspective: uint8 RGB (H, W, 3).

max_grasps: drawn for each object; a hand for the first, axes for the others (x closing red, y green, z approach
blue, grey where infeasible). min_width_px: smaller images are enlarged.)";
  define(
      detection, "draw", signature("self: Detection", keywords(picture_defaults), image_type), doc,
      [](const DetectionResult& self, const py::kwargs& arguments) { return draw("draw", self, arguments); });
  detection.def("__repr__", [](const DetectionResult& self) {
    std::size_t grasps = 0;
    for (const DetectedObject& object : self.detection.objects) grasps += object.grasps.size();
    return "Detection(" + std::to_string(self.detection.objects.size()) + " objects, " +
           std::to_string(grasps) + " grasps)";
  });

  define(
      m, "draw_detection", signature("detection: Detection", keywords(picture_defaults), image_type), doc,
      [](const DetectionResult& self, const py::kwargs& arguments) {
        return draw("draw_detection", self, arguments);
      },
      py::arg("detection"));

  DetectorOptions defaults;
  define(
      m, "detect_grasps",
      signature(
          "left: " + image_type + ", right: " + image_type +
              ", camera: StereoCamera, model: GraspModel | collections.abc.Sequence[GraspModel], *, mask: " +
              mask_type + " | None = None",
          keywords(defaults), "Detection"),
      R"(The whole method: from a stereo pair to ranked grasp configurations.

left, right: uint8 images of the same size, RGB (H, W, 3) or grey (H, W), rectified first if camera.raw says how.
model: one, or several with familiarity that vote on each object, as in choose_model.
mask: uint8 or bool (H, W) instance ids of the left rectified view, used instead of the segmentation.
cues: 'disparity', 'plane' or 'colour'; each adds to the one before (Fig. 2).
fixation_px, roi_px, table, gravity: where to look, and what is known of the rig, as in segment_objects.
max_grasps: of each object. threads: the result is the same for any number.
approach_threshold: φ of Eq. 3, share of the minor semi-axis in the image.
min_probability: of both views together; what is less likely is no grasp.
min_familiarity: what an object is less familiar than, 0 to 1, is unfamiliar and has no grasps; 0 refuses none.
None: 0.03 if several models vote, 0 for one.
Finding nothing is an answer. Raises InvalidInput for unusable images, calibration or options.)",
      [](const py::object& left, const py::object& right, const StereoCamera& camera, const py::object& model,
         const py::object& mask, const py::kwargs& arguments) {
        DetectorOptions options;
        read_keywords("detect_grasps", arguments, keywords(options));
        const cv::Mat left_image = image_argument(left, "left"), right_image = image_argument(right, "right");
        const cv::Mat instance_ids = mask_argument(mask, "mask");
        DetectionResult result;
        result.camera = camera;
        std::vector<GraspModel> models;
        for (const LoadedModel* loaded : models_argument(model, "model")) {
          const std::string comma = models.empty() ? "" : ",";
          result.model_name += comma + loaded->model.name;
          result.model_sha256 += comma + model_sha256(*loaded);
          models.push_back(loaded->model);
        }
        without_gil([&] {
          Detection& found = result.detection;
          found = detect_grasps(left_image, right_image, camera, models, options, instance_ids);
          for (cv::Mat* image : {&found.pair.left, &found.pair.right, &found.segmentation.instance_ids}) {
            own(*image);
          }
        });
        return result;
      },
      py::arg("left"), py::arg("right"), py::arg("camera"), py::arg("model"), py::kw_only(),
      py::arg("mask") = py::none());
}

}  // namespace graspctx::python
