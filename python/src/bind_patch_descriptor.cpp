#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/patch_descriptor.hpp"
#include "options.hpp"

namespace graspctx::python {

void bind_patch_descriptor(py::module_& m) {
  py::class_<PatchDescriptors> patches(m, "PatchDescriptors", "Descriptors of the patches of one view.");
  def_array<float>(patches, "centres", &PatchDescriptors::centres_px,
                   "(M, 2) float32 px of the view, (u, v).");
  def_array<int>(patches, "cells", &PatchDescriptors::cells,
                 "(M, 2) int32 column and row in the patch grid.");
  patches.def_property_readonly(
      "grid", [](const PatchDescriptors& self) { return std::pair(self.grid.width, self.grid.height); },
      "Number of columns and rows.");
  def_array<float>(patches, "features", &PatchDescriptors::features, "(M, 120) float32.");
  patches.def("__len__", [](const PatchDescriptors& self) { return self.cells.size(); });

  DescriptorOptions defaults;
  define(
      m, "patch_descriptors",
      signature("contour: Contour, image_size: tuple[int, int]",
                all_keywords(defaults.shape_context, defaults.patch), "PatchDescriptors"),
      R"(One descriptor for each 10×10 patch that holds contour samples (III-B).

The shape contexts of all samples in a window, summed, at three scales centred at the patch, each L1-normalised
and square-rooted, concatenated: 120 numbers by default. image_size: (width, height) of the view; the grid
starts at its (0, 0). Raises InvalidInput for points outside, or an option out of range.)",
      [](const Contour& contour, std::pair<int, int> image_size, const py::kwargs& arguments) {
        DescriptorOptions options;
        read_keywords("patch_descriptors", arguments, all_keywords(options.shape_context, options.patch));
        return without_gil([&] {
          return patch_descriptors(contour, cv::Size(image_size.first, image_size.second), options);
        });
      },
      py::arg("contour"), py::arg("image_size"));
  define(
      m, "describe_view", signature("view: FovealView", keywords(defaults), "PatchDescriptors"),
      "Contour, shape contexts and patch descriptors of a foveal view. A model's own options are "
      "**model.descriptor.",
      [](const FovealView& view, const py::kwargs& arguments) {
        DescriptorOptions options;
        read_keywords("describe_view", arguments, keywords(options));
        return without_gil([&] { return describe_view(view, options); });
      },
      py::arg("view"));
  m.def(
      "descriptor_defaults",
      [] {
        DescriptorOptions options;
        py::typing::Dict<py::str, py::typing::Dict<py::str, py::object>> stages;
        stages["fovea"] = keyword_values(keywords(options.fovea));
        stages["contour"] = keyword_values(keywords(options.contour));
        stages["shape_context"] = keyword_values(keywords(options.shape_context));
        stages["patch"] = keyword_values(keywords(options.patch));
        return stages;
      },
      "The options of describe_view by the stage that takes them, with their defaults.");
  m.def(
      "robust_descriptor",
      [] {
        DescriptorOptions options = robust_descriptor();
        return keyword_values(keywords(options));
      },
      R"(The options of describe_view that models are trained with by default.

The defaults of describe_view are the descriptor of the paper. Robust is what a mask refined by colour and a second
count of the outline make of it: 240 numbers a patch (docs/recipe.md). Use: describe_view(view, **robust_descriptor()).)");
}

}  // namespace graspctx::python
