#include <pybind11/stl.h>

#include <tuple>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/stereo.hpp"
#include "options.hpp"

namespace graspctx::python {

void bind_stereo(py::module_& m) {
  define(
      m, "rectify",
      "(left: " + image_type + ", right: " + image_type + ", camera: StereoCamera) -> tuple[" + image_type +
          ", " + image_type + "]",
      "Check a pair of images against the camera, and rectify it if camera.raw says how (METHOD 1).\n\n"
      "Images are uint8, RGB (H, W, 3) or grey (H, W). Raises InvalidInput if sizes differ from each other "
      "or "
      "from the calibration's.",
      [](const py::object& left, const py::object& right, const StereoCamera& camera) {
        const cv::Mat left_image = image_argument(left, "left"), right_image = image_argument(right, "right");
        const RectifiedPair pair = without_gil([&] { return rectify(left_image, right_image, camera); });
        return py::make_tuple(image_result(pair.left), image_result(pair.right));
      },
      py::arg("left"), py::arg("right"), py::arg("camera"));

  DisparityOptions defaults;
  define(
      m, "compute_disparity",
      signature("left: " + image_type + ", right: " + image_type + ", *, reliable: bool = False, " +
                    "instance_ids: " + mask_type + " | None = None",
                keywords(defaults), float32_type),
      R"(Disparity (px) of the left view of a rectified pair: (H, W) float32, NaN where unknown (METHOD 1).

left, right: uint8 images of the same size, RGB (H, W, 3) or grey (H, W).
reliable: keep only what is consistent from right to left, and textured.
instance_ids: uint8 or bool (H, W), match the pixels that are not 0 again at full resolution.
max_disparity_px: 0 means a quarter of the width.
Raises InvalidInput if the sizes differ or an option is out of range.)",
      [](const py::object& left, const py::object& right, bool reliable, const py::object& instance_ids,
         const py::kwargs& arguments) {
        DisparityOptions options;
        read_keywords("compute_disparity", arguments, keywords(options));
        const RectifiedPair pair{image_argument(left, "left"), image_argument(right, "right")};
        const cv::Mat instances = mask_argument(instance_ids, "instance_ids");
        Disparity disparity = without_gil([&] {
          const Disparity coarse = compute_disparity(pair, options);
          return instances.empty() ? coarse : refine_disparity(pair, coarse, instances, options);
        });
        return moved<float>(std::move(reliable ? disparity.reliable : disparity.dense));
      },
      py::arg("left"), py::arg("right"), py::kw_only(), py::arg("reliable") = false,
      py::arg("instance_ids") = py::none());
}

}  // namespace graspctx::python
