#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <algorithm>
#include <optional>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/error.hpp"
#include "graspctx/explanation.hpp"
#include "graspctx/io/explanation_json.hpp"
#include "graspctx/io/picture.hpp"
#include "options.hpp"

namespace graspctx::python {

namespace {

/// An explanation knows its model, for its JSON and for finding training patches.
struct ExplanationResult {
  GraspExplanation explanation;
  LoadedModel model;
  std::string model_sha256;
};

std::string to_json(const ExplanationResult& self, std::optional<int> indent) {
  return without_gil([&] {
    const std::string& name = self.model.model.name;
    return indent ? explanation_to_json(self.explanation, name, self.model_sha256, *indent)
                  : explanation_to_json(self.explanation, name, self.model_sha256);
  });
}

const DetectedObject& chosen_object(const Detection& detection, std::optional<int> object_id) {
  if (detection.objects.empty()) throw InvalidInput("detection: no object was found, nothing to explain");
  if (!object_id) return detection.objects.front();
  const auto found = std::find_if(detection.objects.begin(), detection.objects.end(),
                                  [&](const DetectedObject& object) { return object.id == *object_id; });
  if (found == detection.objects.end()) {
    throw InvalidInput("object_id: the detection has no object " + std::to_string(*object_id));
  }
  return *found;
}

py::array_t<std::uint8_t> draw(const ExplanationResult& self,
                               const std::optional<std::vector<LabelledView>>& training_views) {
  return image_result(without_gil([&] {
    if (!training_views) return draw_explanation(self.explanation);
    GraspExplanation explanation = self.explanation;
    explanation.patch = find_training_patches(explanation.patch, self.model.model, *training_views);
    return draw_explanation(explanation);
  }));
}

void bind_near_image(py::module_& m) {
  py::class_<NearImage> image(
      m, "NearImage", "A training image as the model remembers it: its support vectors of one label.");
  image.def_readonly("name", &NearImage::name, "Of the image or scene, within its data set.");
  image.def_readonly("support_vector", &NearImage::support_vector,
                     "The nearest one: its row in GraspModel.support_vectors.");
  image.def_readonly("similarity", &NearImage::similarity, "Its kernel value, 0 to 1.");
  image.def_readonly("support_vectors", &NearImage::support_vectors, "How many.");
  image.def_readonly("contribution", &NearImage::contribution, "Of all of them to f: Σ coefficient · K.");
  image.def("__repr__", [](const NearImage& self) {
    return py::str("NearImage({!r}, similarity={:.3f})").format(self.name, self.similarity);
  });
}

/// A property of the explanation of the patch.
template <typename Class, typename Value>
void def_patch_value(Class& class_, const char* name, Value PatchExplanation::*member, const char* doc) {
  class_.def_property_readonly(
      name, [member](const ExplanationResult& self) { return self.explanation.patch.*member; }, doc);
}

}  // namespace

void bind_explanation(py::module_& m) {
  bind_near_image(m);
  py::class_<ExplanationResult> explanation(
      m, "GraspExplanation",
      R"(What the decision value f of a grasp's patch in the left view rests on. Made by explain_grasp.

An effect is by how much f falls when something is taken away: it speaks for a grasping point if positive.)");
  explanation.def_property_readonly(
      "object_id", [](const ExplanationResult& self) { return self.explanation.object_id; },
      "DetectedObject.id.");
  explanation.def_property_readonly(
      "grasp", [](const ExplanationResult& self) { return self.explanation.grasp; }, "The grasp explained.");
  explanation.def_property_readonly(
      "view", [](const ExplanationResult& self) { return self.explanation.view; }, "The left foveal view.");
  explanation.def_property_readonly(
      "contour", [](const ExplanationResult& self) { return self.explanation.contour; }, "Of the view.");
  explanation.def_property_readonly(
      "centre_px",
      [](const ExplanationResult& self) {
        const cv::Point2f& centre = self.explanation.patch.centre_px;
        return std::pair(centre.x, centre.y);
      },
      "The patch's centre (u, v) in the view.");
  def_patch_value(explanation, "decision_value", &PatchExplanation::decision_value, "f of the patch.");
  def_patch_value(explanation, "probability", &PatchExplanation::probability,
                  "P(g = 1 | D) of the patch in the left view.");
  explanation.def_property_readonly(
      "point_effects",
      [](const ExplanationResult& self) {
        const std::vector<double>& effects = self.explanation.patch.point_effects;
        return copied(
            Eigen::Map<const Eigen::VectorXd>(effects.data(), static_cast<Eigen::Index>(effects.size())));
      },
      "(N,) float64: of each contour sample, left out.");
  explanation.def_property_readonly(
      "bin_effects",
      [](const ExplanationResult& self) {
        const ShapeContextOptions& shape = self.explanation.descriptor.shape_context;
        const py::ssize_t parts = shape.outline_px > 0 ? 2 : 1;
        const Eigen::VectorXd& effects = self.explanation.patch.bin_effects;
        py::array_t<double> array({py::ssize_t{3}, parts, static_cast<py::ssize_t>(shape.angular_bins),
                                   static_cast<py::ssize_t>(shape.radial_bins)});
        std::copy(effects.begin(), effects.end(), array.mutable_data());
        return array;
      },
      "(3, 1 or 2, angular_bins, radial_bins) float64: of each bin of each window, put to its training mean; "
      "of "
      "all points, and with outline_px of the outline alone.");
  def_patch_value(explanation, "other_effect", &PatchExplanation::other_effect,
                  "Of all features behind the shape context, put to their means; None if there are none.");
  def_patch_value(explanation, "ring_radii_px", &PatchExplanation::ring_radii_px,
                  "Outer radius of each ring of the bins, in the view.");
  def_patch_value(
      explanation, "graspable", &PatchExplanation::graspable,
      "Training images whose graspable patches are like this one, the most similar first; empty if "
      "the model does not know its images.");
  def_patch_value(explanation, "not_graspable", &PatchExplanation::not_graspable,
                  "The same for patches that are not graspable.");
  explanation.def("to_json", &to_json, py::arg("indent") = py::none(),
                  "The explanation as JSON, schema 1 (docs/explain.md). indent < 0: one line.");
  explanation.def(
      "to_dict",
      [](const ExplanationResult& self) -> py::typing::Dict<py::str, py::object> {
        return py::module_::import("json").attr("loads")(to_json(self, -1));
      },
      "The same as a dict of plain Python values.");
  define(explanation, "draw",
         "(self: GraspExplanation, *, training_views: collections.abc.Sequence[LabelledView] | None = None) "
         "-> " +
             image_type,
         R"(One picture of it: uint8 RGB (H, W, 3).

The view with its contour samples, blue where they speak for a grasping point, orange against; the patch and its
windows; the bins of each window as seen in the image; the nearest training images by name.
training_views: of the data set that the model was trained on; the nearest images are then drawn. Raises
InvalidInput if one of them is missing.)",
         &draw, py::kw_only(), py::arg("training_views") = py::none());
  explanation.def("__repr__", [](const ExplanationResult& self) {
    return py::str("GraspExplanation(object_id={}, rank={}, decision_value={:.3f})")
        .format(self.explanation.object_id, self.explanation.grasp.rank,
                self.explanation.patch.decision_value);
  });

  ExplanationOptions defaults;
  define(
      m, "explain_grasp",
      signature("detection: Detection, model: GraspModel, *, object_id: int | None = None, rank: int = 1",
                keywords(defaults), "GraspExplanation"),
      R"(Why there is a grasp: what its patch in the left view rests on.

model: the one that the detection was made with. object_id: DetectedObject.id; by default the first object. rank:
of its grasps, from 1. max_images: nearest training images of each label.
Each contour sample is left out exactly, from the windows that hold it and from the histograms of all others; only
the mean pairwise distance stays. Each bin is put to its training mean; one by one, so the effects do not add up to f.
Raises InvalidInput if there is no such grasp, or the model is another.)",
      [](const DetectionResult& detection, const LoadedModel& model, std::optional<int> object_id, int rank,
         const py::kwargs& arguments) {
        ExplanationOptions options;
        read_keywords("explain_grasp", arguments, keywords(options));
        ExplanationResult result{{}, model, model_sha256(model)};
        if (result.model_sha256 != detection.model_sha256) {
          throw InvalidInput("model: expected '" + detection.model_name +
                             "', which the detection was made with, got '" + model.model.name + "'");
        }
        without_gil([&] {
          const DetectedObject& object = chosen_object(detection.detection, object_id);
          result.explanation = explain_grasp(object, model.model, rank, options);
        });
        return result;
      },
      py::arg("detection"), py::arg("model"), py::kw_only(), py::arg("object_id") = py::none(),
      py::arg("rank") = 1);
}

}  // namespace graspctx::python
