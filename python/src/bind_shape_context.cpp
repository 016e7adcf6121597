#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/shape_context.hpp"
#include "options.hpp"

namespace graspctx::python {

void bind_shape_context(py::module_& m) {
  ShapeContextOptions defaults;
  define(
      m, "shape_contexts",
      signature("points: " + float32_type + ", *, gradients: " + float32_type +
                    " | None = None, border_distances: " + float32_type + " | None = None",
                keywords(defaults), float32_type),
      R"(Log-polar histograms of the vectors from each point to all the others (III-B; Belongie et al. 2002).

points: float32 (N, 2) px. Returns float32 counts (N, angular_bins · radial_bins), angle-major
(angle * radial_bins + radius); angle bin 0 starts at +u and turns towards +v. Radii are in units of the mean
pairwise distance; nearer than inner_radius falls into the first ring, farther than outer_radius into none.
gradients: float32 (N,) rad, needed for relative_to_gradient only. border_distances: float32 (N,) px, needed for
outline_px only: points at most that far inside the mask are its outline, and (N, 2 · angular_bins · radial_bins)
counts come back, of the vectors to all points, then of those to points of the outline.)",
      [](const py::object& points, const py::object& gradients, const py::object& border_distances,
         const py::kwargs& arguments) {
        ShapeContextOptions options;
        read_keywords("shape_contexts", arguments, keywords(options));
        const std::vector<cv::Point2f> points_px = points_argument(points, "points");
        const std::vector<float> gradients_rad = floats_argument(gradients, "gradients");
        const std::vector<float> border_px = floats_argument(border_distances, "border_distances");
        return moved<float>(
            without_gil([&] { return shape_contexts(points_px, options, gradients_rad, border_px); }));
      },
      py::arg("points"), py::kw_only(), py::arg("gradients") = py::none(),
      py::arg("border_distances") = py::none());
}

}  // namespace graspctx::python
