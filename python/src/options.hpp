#pragma once
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "graspctx/dataset.hpp"
#include "graspctx/detector.hpp"
#include "graspctx/explanation.hpp"
#include "graspctx/io/picture.hpp"

/// Options as keyword arguments. The names are listed once, here; the defaults are those of the C++ structs.
namespace graspctx::python {

namespace py = pybind11;

/// A keyword argument and the member of an options struct that it sets.
struct Keyword {
  std::string name;
  std::variant<bool*, int*, std::uint32_t*, double*, std::array<int, 3>*, std::vector<double>*,
               std::optional<double>*, CueLevel*, std::optional<Eigen::Vector2d>*,
               std::optional<Eigen::Vector3d>*, std::optional<cv::Rect>*, std::optional<TablePlane>*>
      member;
};
using Keywords = std::vector<Keyword>;

Keywords keywords(FoveaOptions& options);
Keywords keywords(ContourOptions& options);
Keywords keywords(ShapeContextOptions& options);
Keywords keywords(PatchOptions& options);
Keywords keywords(DescriptorOptions& options);
Keywords keywords(AugmentOptions& options);
Keywords keywords(TrainOptions& options);
Keywords keywords(DisparityOptions& options);
Keywords keywords(SegmentationOptions& options);
Keywords keywords(GraspPointOptions& options);
Keywords keywords(StereoMatchOptions& options);
Keywords keywords(HandOptions& options);
Keywords keywords(DetectorOptions& options);
Keywords keywords(PictureOptions& options);
Keywords keywords(ExplanationOptions& options);

/// The keywords of several structs that one function takes.
template <typename... Options>
Keywords all_keywords(Options&... options) {
  Keywords all;
  const auto append = [&](Keywords some) { all.insert(all.end(), some.begin(), some.end()); };
  (append(keywords(options)), ...);
  return all;
}

/// Set the members that the arguments name. Unknown names and wrong types raise TypeError.
void read_keywords(const std::string& function, const py::dict& arguments, const Keywords& keywords);
/// The options' present values, by name.
py::dict keyword_values(const Keywords& keywords);

/// "(image: Image, *, samples: int = 300) -> Contour", with the present values as defaults.
std::string signature(const std::string& arguments, const Keywords& keywords, const std::string& returns);

/// Define a function that takes options: its signature, with their defaults, is the docstring's first line.
template <typename Scope, typename Function, typename... Extra>
void define(Scope& scope, const std::string& name, const std::string& signature, const std::string& doc,
            Function&& function, Extra&&... extra) {
  py::options docstrings;
  docstrings.disable_function_signatures();
  scope.def(name.c_str(), std::forward<Function>(function), (name + signature + "\n\n" + doc).c_str(),
            std::forward<Extra>(extra)...);
}

/// The same for a constructor: define_init(class_, "(self: …)", "…", py::init(…), py::arg("points")).
template <typename Class, typename Init, typename... Extra>
void define_init(Class& class_, const std::string& signature, const std::string& doc, Init&& init,
                 Extra&&... extra) {
  py::options docstrings;
  docstrings.disable_function_signatures();
  class_.def(std::forward<Init>(init), ("__init__" + signature + "\n\n" + doc).c_str(),
             std::forward<Extra>(extra)...);
}

/// Annotations that numpy understands.
inline const std::string image_type = "numpy.typing.NDArray[numpy.uint8]",
                         mask_type = "numpy.typing.NDArray[numpy.uint8] | numpy.typing.NDArray[numpy.bool_]",
                         float32_type = "numpy.typing.NDArray[numpy.float32]",
                         float64_type = "numpy.typing.NDArray[numpy.float64]",
                         integer_type = "numpy.typing.NDArray[numpy.integer]";

}  // namespace graspctx::python
