#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/contour.hpp"
#include "options.hpp"

namespace graspctx::python {

void bind_contour(py::module_& m) {
  py::class_<Contour> contour(m, "Contour",
                              "Samples of an object's contour: its outline and its inner edges.");
  define_init(
      contour,
      "(self: Contour, points: " + float32_type + ", gradients: " + float32_type +
          " | None = None, border_distances: " + float32_type + " | None = None) -> None",
      "points: float32 (N, 2) px. gradients: float32 (N,) rad. border_distances: float32 (N,) px.",
      py::init([](const py::object& points, const py::object& gradients, const py::object& border_distances) {
        Contour result{points_argument(points, "points"), floats_argument(gradients, "gradients"),
                       floats_argument(border_distances, "border_distances")};
        if (!gradients.is_none() && result.gradients_rad.size() != result.points.size()) {
          throw py::value_error("gradients: expected one for each of the " +
                                std::to_string(result.points.size()) + " points, got " +
                                std::to_string(result.gradients_rad.size()));
        }
        if (!border_distances.is_none() && result.border_px.size() != result.points.size()) {
          throw py::value_error("border_distances: expected one for each of the " +
                                std::to_string(result.points.size()) + " points, got " +
                                std::to_string(result.border_px.size()));
        }
        return result;
      }),
      py::arg("points"), py::arg("gradients") = py::none(), py::arg("border_distances") = py::none());
  def_array<float>(contour, "points", &Contour::points, "(N, 2) float32 px, (u, v).");
  def_array<float>(contour, "gradients", &Contour::gradients_rad,
                   "(N,) float32 rad, direction of the intensity gradient from +u towards +v.");
  def_array<float>(contour, "border_distances", &Contour::border_px,
                   "(N,) float32 px to the nearest pixel outside the mask, 0 outside it.");
  contour.def("__len__", [](const Contour& self) { return self.points.size(); });
  contour.def("__repr__", [](const Contour& self) {
    return "Contour(" + std::to_string(self.points.size()) + " points)";
  });

  ContourOptions defaults;
  define(
      m, "sample_contour",
      signature("image: " + image_type + ", mask: " + mask_type + " | None = None", keywords(defaults),
                "Contour"),
      R"(Canny on the unmasked image, the edges inside the mask, sampled evenly along the edges (III-B, Fig. 3).

image: uint8, RGB (H, W, 3) or grey (H, W). mask: uint8 or bool (H, W), > 0 = object; None for the whole image.
samples: 0 for every contour pixel. Raises InvalidInput if the sizes differ or an option is out of range.)",
      [](const py::object& image, const py::object& mask, const py::kwargs& arguments) {
        ContourOptions options;
        read_keywords("sample_contour", arguments, keywords(options));
        const cv::Mat pixels = image_argument(image, "image"), marked = mask_argument(mask, "mask");
        return without_gil([&] { return sample_contour(pixels, marked, options); });
      },
      py::arg("image"), py::arg("mask") = py::none());
}

}  // namespace graspctx::python
