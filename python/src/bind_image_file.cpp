#include <pybind11/stl/filesystem.h>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/io/image_file.hpp"
#include "options.hpp"

namespace graspctx::python {

void bind_image_file(py::module_& m) {
  m.def(
      "read_image",
      [](const std::filesystem::path& path) {
        return image_result(without_gil([&] { return read_image(path); }));
      },
      py::arg("path"),
      "Read a PNG or JPEG file: uint8 RGB (H, W, 3), or (H, W) if the file is grey. Raises InvalidInput "
      "naming "
      "the file if it is missing, damaged or too large.");
  define(
      m, "write_image", "(path: str | os.PathLike[str], image: " + image_type + ") -> None",
      "Write an RGB (H, W, 3) or grey (H, W) uint8 image as PNG or JPEG, all or nothing.",
      [](const std::filesystem::path& path, const py::object& image) {
        const cv::Mat pixels = image_argument(image, "image");
        without_gil([&] { write_image(path, pixels); });
      },
      py::arg("path"), py::arg("image"));
}

}  // namespace graspctx::python
