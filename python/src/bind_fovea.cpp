#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/error.hpp"
#include "graspctx/fovea.hpp"
#include "options.hpp"

namespace graspctx::python {

namespace {

template <typename Function>
py::array_t<double> map_pixels(const py::object& pixels, const char* name, const Function& function) {
  const auto from = vectors_argument(pixels, 2, name);
  py::array_t<double> to(std::vector<py::ssize_t>(from.shape(), from.shape() + from.ndim()));
  for (py::ssize_t i = 0; i < from.size(); i += 2) {
    Eigen::Map<Eigen::Vector2d>(to.mutable_data() + i) =
        function(Eigen::Vector2d(from.data()[i], from.data()[i + 1]));
  }
  return to;
}

}  // namespace

void bind_fovea(py::module_& m) {
  py::class_<FovealView> view(m, "FovealView", R"(A view re-sampled around one object at a fixed object size.

view_px = scale · (image_px − origin_px))");
  view.def_property_readonly(
      "image", [](const FovealView& self) { return image_result(self.image); }, "uint8, RGB or grey.");
  def_array<std::uint8_t>(view, "mask", &FovealView::mask, "(H, W) uint8, 255 = object.");
  view.def_readonly("scale", &FovealView::scale, "View pixels per image pixel.");
  def_vector(view, "origin_px", &FovealView::origin_px, "(2,) image pixel at the view's (0, 0).");
  const std::string pixels = ": numpy.typing.ArrayLike) -> " + float64_type;
  define(
      view, "view_from_image", "(self: FovealView, image_px" + pixels, "Pixels (..., 2) of the view.",
      [](const FovealView& self, const py::object& image_px) {
        return map_pixels(image_px, "image_px",
                          [&](const Eigen::Vector2d& px) { return self.view_from_image(px); });
      },
      py::arg("image_px"));
  define(
      view, "image_from_view", "(self: FovealView, view_px" + pixels, "Pixels (..., 2) of the full image.",
      [](const FovealView& self, const py::object& view_px) {
        return map_pixels(view_px, "view_px",
                          [&](const Eigen::Vector2d& px) { return self.image_from_view(px); });
      },
      py::arg("view_px"));

  py::class_<FovealPair>(m, "FovealPair", "Both views of one object, fixated on it.")
      .def_readonly("left", &FovealPair::left)
      .def_readonly("right", &FovealPair::right)
      .def_readonly("fixation_disparity_px", &FovealPair::fixation_disparity_px,
                    "Left origin's u minus the right one's.");

  FoveaOptions defaults;
  define(
      m, "foveal_view",
      signature("image: " + image_type + ", mask: " + mask_type, keywords(defaults), "FovealView"),
      R"(The foveal view of the object that the mask marks (METHOD 2).

image: uint8, RGB (H, W, 3) or grey (H, W). mask: uint8 or bool (H, W), > 0 = object.
object_px: longer side of the object in the view. Raises InvalidInput for an empty mask or another size.)",
      [](const py::object& image, const py::object& mask, const py::kwargs& arguments) {
        FoveaOptions options;
        read_keywords("foveal_view", arguments, keywords(options));
        const cv::Mat pixels_in = image_argument(image, "image"), marked = mask_argument(mask, "mask");
        if (marked.empty())
          throw py::type_error("mask: expected a uint8 or bool array of shape (H, W), got None");
        FovealView result = without_gil([&] { return foveal_view(pixels_in, marked, options); });
        own(result.image);
        own(result.mask);
        return result;
      },
      py::arg("image"), py::arg("mask"));
}

}  // namespace graspctx::python
