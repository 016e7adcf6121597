#include "options.hpp"

#include <algorithm>
#include <limits>

#include "arrays.hpp"

namespace graspctx::python {

namespace {

const std::vector<std::pair<std::string, CueLevel>> cue_levels{
    {"disparity", CueLevel::disparity}, {"plane", CueLevel::plane}, {"colour", CueLevel::colour}};

[[noreturn]] void wrong_type(const std::string& name, const std::string& expected, py::handle value) {
  throw py::type_error(name + ": expected " + expected + ", got " + describe(value));
}

/// Any integer that fits, numpy's included; bool and float are none.
template <typename Integer>
Integer integer(const std::string& name, py::handle value) {
  if (PyBool_Check(value.ptr()) || !PyIndex_Check(value.ptr()) || py::isinstance<py::array>(value)) {
    wrong_type(name, "an int", value);
  }
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!index) throw py::error_already_set();
  int overflow = 0;
  const long long wide = PyLong_AsLongLongAndOverflow(index.ptr(), &overflow);
  if (overflow != 0 || wide < static_cast<long long>(std::numeric_limits<Integer>::min()) ||
      wide > static_cast<long long>(std::numeric_limits<Integer>::max())) {
    throw py::value_error(
        name + ": expected an int from " + std::to_string(std::numeric_limits<Integer>::min()) + " to " +
        std::to_string(std::numeric_limits<Integer>::max()) + ", got " + py::str(index).cast<std::string>());
  }
  return static_cast<Integer>(wide);
}

/// Any real number, numpy's included; bool and str are none.
double real(const std::string& name, py::handle value) {
  const bool number = PyFloat_Check(value.ptr()) || PyIndex_Check(value.ptr()) || PyNumber_Check(value.ptr());
  if (PyBool_Check(value.ptr()) || PyComplex_Check(value.ptr()) || py::isinstance<py::array>(value) ||
      !number) {
    wrong_type(name, "a float", value);
  }
  const double result = PyFloat_AsDouble(value.ptr());
  if (result == -1.0 && PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    wrong_type(name, "a float", value);
  }
  return result;
}

/// The items of a list, tuple or array.
std::vector<py::object> items(const std::string& name, const std::string& expected, py::handle value) {
  if (py::isinstance<py::str>(value) || !py::isinstance<py::sequence>(value))
    wrong_type(name, expected, value);
  std::vector<py::object> result;
  for (const py::handle item : py::iter(value)) result.push_back(py::reinterpret_borrow<py::object>(item));
  return result;
}

std::vector<py::object> items(const std::string& name, const std::string& expected, py::handle value,
                              std::size_t count) {
  std::vector<py::object> result = items(name, expected, value);
  if (result.size() != count) {
    throw py::value_error(name + ": expected " + expected + ", got " + std::to_string(result.size()) +
                          " values");
  }
  return result;
}

/// How each type of member is set from Python, given back, and annotated.
struct Member {
  const std::string& name;

  void set(bool& member, py::handle value) const {
    if (!PyBool_Check(value.ptr())) wrong_type(name, "a bool", value);
    member = value.ptr() == Py_True;
  }
  void set(int& member, py::handle value) const { member = integer<int>(name, value); }
  void set(std::uint32_t& member, py::handle value) const { member = integer<std::uint32_t>(name, value); }
  void set(double& member, py::handle value) const { member = real(name, value); }
  void set(std::array<int, 3>& member, py::handle value) const {
    const auto values = items(name, "3 ints", value, 3);
    for (std::size_t i = 0; i < 3; ++i) member[i] = integer<int>(name, values[i]);
  }
  void set(std::vector<double>& member, py::handle value) const {
    member.clear();
    for (const py::object& item : items(name, "a sequence of floats", value)) {
      member.push_back(real(name, item));
    }
  }
  void set(std::optional<double>& member, py::handle value) const {
    member.reset();
    if (!value.is_none()) member = real(name, value);
  }
  void set(CueLevel& member, py::handle value) const {
    if (!py::isinstance<py::str>(value)) wrong_type(name, "a str", value);
    const auto wanted = value.cast<std::string>();
    for (const auto& [level_name, level] : cue_levels) {
      if (level_name == wanted) {
        member = level;
        return;
      }
    }
    throw py::value_error(name + ": expected 'disparity', 'plane' or 'colour', got '" + wanted + "'");
  }
  void set(std::optional<Eigen::Vector2d>& member, py::handle value) const {
    member.reset();
    if (value.is_none()) return;
    const auto values = items(name, "a pixel (u, v)", value, 2);
    member = Eigen::Vector2d(real(name, values[0]), real(name, values[1]));
  }
  void set(std::optional<Eigen::Vector3d>& member, py::handle value) const {
    member.reset();
    if (value.is_none()) return;
    const auto values = items(name, "a vector (x, y, z)", value, 3);
    member = Eigen::Vector3d(real(name, values[0]), real(name, values[1]), real(name, values[2]));
  }
  void set(std::optional<cv::Rect>& member, py::handle value) const {
    member.reset();
    if (value.is_none()) return;
    const auto values = items(name, "a box (x, y, width, height)", value, 4);
    member = cv::Rect(integer<int>(name, values[0]), integer<int>(name, values[1]),
                      integer<int>(name, values[2]), integer<int>(name, values[3]));
  }
  void set(std::optional<TablePlane>& member, py::handle value) const {
    member.reset();
    if (value.is_none()) return;
    if (py::isinstance<TablePlane>(value)) {
      member = value.cast<TablePlane>();
      return;
    }
    const auto values = items(name, "a TablePlane or (nx, ny, nz, offset_m)", value, 4);
    member.emplace();
    member->normal = {real(name, values[0]), real(name, values[1]), real(name, values[2])};
    member->offset_m = real(name, values[3]);
  }
};

template <typename Value>
py::object get(const Value& member) {
  return py::cast(member);
}
py::object get(const std::array<int, 3>& member) {
  return py::make_tuple(member[0], member[1], member[2]);
}
py::object get(const std::vector<double>& member) {
  py::list values;
  for (const double value : member) values.append(value);
  return py::tuple(values);
}
py::object get(const std::optional<double>& member) {
  if (!member) return py::none();
  return py::float_(*member);
}
py::object get(CueLevel member) {
  return py::str(std::find_if(cue_levels.begin(), cue_levels.end(), [&](const auto& level) {
                   return level.second == member;
                 })->first);
}
py::object get(const std::optional<Eigen::Vector2d>& member) {
  if (!member) return py::none();
  return py::make_tuple(member->x(), member->y());
}

py::object get(const std::optional<Eigen::Vector3d>& member) {
  if (!member) return py::none();
  return py::make_tuple(member->x(), member->y(), member->z());
}
py::object get(const std::optional<cv::Rect>& member) {
  if (!member) return py::none();
  return py::make_tuple(member->x, member->y, member->width, member->height);
}
py::object get(const std::optional<TablePlane>& member) {
  if (!member) return py::none();
  return py::cast(*member);
}

const char* annotation(bool*) {
  return "bool";
}
const char* annotation(int*) {
  return "int";
}
const char* annotation(std::uint32_t*) {
  return "int";
}
const char* annotation(double*) {
  return "float";
}
const char* annotation(std::array<int, 3>*) {
  return "tuple[int, int, int]";
}
const char* annotation(std::vector<double>*) {
  return "collections.abc.Sequence[float]";
}
const char* annotation(std::optional<double>*) {
  return "float | None";
}
const char* annotation(CueLevel*) {
  return "str";
}
const char* annotation(std::optional<Eigen::Vector2d>*) {
  return "tuple[float, float] | None";
}
const char* annotation(std::optional<Eigen::Vector3d>*) {
  return "tuple[float, float, float] | None";
}
const char* annotation(std::optional<cv::Rect>*) {
  return "tuple[int, int, int, int] | None";
}
const char* annotation(std::optional<TablePlane>*) {
  return "TablePlane | tuple[float, float, float, float] | None";
}

}  // namespace

Keywords keywords(FoveaOptions& options) {
  return {{"object_px", &options.object_px},
          {"margin_px", &options.margin_px},
          {"refine_mask", &options.refine_mask}};
}

Keywords keywords(ContourOptions& options) {
  return {{"canny_low", &options.canny_low},
          {"canny_high", &options.canny_high},
          {"samples", &options.samples},
          {"mask_margin_px", &options.mask_margin_px}};
}

Keywords keywords(ShapeContextOptions& options) {
  return {{"angular_bins", &options.angular_bins},
          {"radial_bins", &options.radial_bins},
          {"inner_radius", &options.inner_radius},
          {"outer_radius", &options.outer_radius},
          {"relative_to_gradient", &options.relative_to_gradient},
          {"outline_px", &options.outline_px}};
}

Keywords keywords(PatchOptions& options) {
  return {{"patch_px", &options.patch_px}, {"windows_patches", &options.windows_patches}};
}

Keywords keywords(DescriptorOptions& options) {
  return all_keywords(options.fovea, options.contour, options.shape_context, options.patch);
}

Keywords keywords(AugmentOptions& options) {
  return {{"degraded_masks", &options.degraded_masks}, {"seed", &options.seed}};
}

Keywords keywords(TrainOptions& options) {
  return {{"svm_c", &options.svm_c},
          {"gamma_times_dimension", &options.gamma_times_dimension},
          {"folds", &options.folds},
          {"max_positives_per_group", &options.max_positives_per_group},
          {"max_negatives_per_group", &options.max_negatives_per_group},
          {"max_rows", &options.max_rows},
          {"max_search_rows", &options.max_search_rows},
          {"seed", &options.seed}};
}

Keywords keywords(DisparityOptions& options) {
  return {{"max_disparity_px", &options.max_disparity_px},
          {"half_resolution", &options.half_resolution},
          {"block_px", &options.block_px},
          {"uniqueness_percent", &options.uniqueness_percent},
          {"speckle_px", &options.speckle_px},
          {"left_right_px", &options.left_right_px},
          {"texture_sigmas", &options.texture_sigmas}};
}

Keywords keywords(SegmentationOptions& options) {
  return {{"cues", &options.cues},
          {"max_objects", &options.max_objects},
          {"min_height_m", &options.min_height_m},
          {"max_height_m", &options.max_height_m},
          {"min_extent_m", &options.min_extent_m},
          {"max_extent_m", &options.max_extent_m},
          {"min_reliable_share", &options.min_reliable_share},
          {"cell_m", &options.cell_m},
          {"fixation_px", &options.fixation_px},
          {"roi_px", &options.roi_px},
          {"table", &options.table},
          {"gravity", &options.gravity}};
}

Keywords keywords(GraspPointOptions& options) {
  return {{"max_points", &options.max_points}, {"neighbour_ratio", &options.neighbour_ratio}};
}

Keywords keywords(StereoMatchOptions& options) {
  return {{"window_px", &options.window_px},
          {"search_px", &options.search_px},
          {"min_correlation", &options.min_correlation}};
}

Keywords keywords(HandOptions& options) {
  return {
      {"max_opening_m", &options.max_opening_m},           {"opening_margin_m", &options.opening_margin_m},
      {"finger_length_m", &options.finger_length_m},       {"finger_width_m", &options.finger_width_m},
      {"finger_thickness_m", &options.finger_thickness_m}, {"finger_spread_m", &options.finger_spread_m},
      {"palm_radius_m", &options.palm_radius_m},           {"tip_beyond_m", &options.tip_beyond_m},
      {"table_clearance_m", &options.table_clearance_m},   {"retreat_m", &options.retreat_m}};
}

Keywords keywords(DetectorOptions& options) {
  Keywords own{{"max_grasps", &options.max_grasps},
               {"threads", &options.threads},
               {"approach_threshold", &options.approach_threshold},
               {"min_probability", &options.min_probability},
               {"min_familiarity", &options.min_familiarity}};
  const Keywords stages = all_keywords(options.segmentation, options.disparity, options.grasp_points,
                                       options.stereo_match, options.hand);
  own.insert(own.end(), stages.begin(), stages.end());
  return own;
}

Keywords keywords(PictureOptions& options) {
  Keywords own{{"max_grasps", &options.max_grasps},
               {"contour", &options.contour},
               {"probabilities", &options.probabilities},
               {"pose", &options.pose},
               {"min_width_px", &options.min_width_px}};
  const Keywords hand = keywords(options.hand);
  own.insert(own.end(), hand.begin(), hand.end());
  return own;
}

Keywords keywords(ExplanationOptions& options) {
  return {{"max_images", &options.max_images}};
}

void read_keywords(const std::string& function, const py::dict& arguments, const Keywords& keywords) {
  for (const auto& [key, value] : arguments) {
    const std::string name = py::str(key);
    const auto found = std::find_if(keywords.begin(), keywords.end(),
                                    [&](const Keyword& keyword) { return keyword.name == name; });
    if (found == keywords.end()) {
      std::string known;
      for (const Keyword& keyword : keywords) known += (known.empty() ? "" : ", ") + keyword.name;
      throw py::type_error(function + "(): unknown option '" + name + "'; expected one of: " + known);
    }
    std::visit([&, &argument = value](auto* member) { Member{name}.set(*member, argument); }, found->member);
  }
}

py::dict keyword_values(const Keywords& keywords) {
  py::dict values;
  for (const Keyword& keyword : keywords) {
    std::visit([&](const auto* member) { values[keyword.name.c_str()] = get(*member); }, keyword.member);
  }
  return values;
}

std::string signature(const std::string& arguments, const Keywords& keywords, const std::string& returns) {
  std::string text = "(" + arguments;
  if (!keywords.empty() && arguments.find("*, ") == std::string::npos) text += ", *";
  const py::dict defaults = keyword_values(keywords);
  for (const Keyword& keyword : keywords) {
    const std::string type = std::visit([](auto* member) { return annotation(member); }, keyword.member);
    text += ", " + keyword.name + ": " + type + " = " +
            py::repr(defaults[keyword.name.c_str()]).cast<std::string>();
  }
  return text + ") -> " + returns;
}

}  // namespace graspctx::python
