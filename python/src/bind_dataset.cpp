#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <optional>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/dataset.hpp"
#include "graspctx/io/dataset_files.hpp"
#include "options.hpp"

namespace graspctx::python {

namespace {

DatasetViews which_views(const std::string& name) {
  if (name == "left") return DatasetViews::left;
  if (name == "both") return DatasetViews::both;
  throw py::value_error("views: expected 'left' or 'both', got '" + name + "'");
}

DatasetOptions dataset_options(const std::string& format, std::vector<std::string> classes,
                               std::vector<std::string> object_labels,
                               std::vector<std::string> grasp_labels) {
  DatasetOptions options;
  bool is_known = false;
  for (const DatasetFormat known : {DatasetFormat::detect, DatasetFormat::graspctx, DatasetFormat::saxena,
                                    DatasetFormat::labelme, DatasetFormat::coco}) {
    if (format == name_of(known)) options.format = known, is_known = true;
  }
  if (!is_known) {
    throw py::value_error("format: expected 'detect', 'graspctx', 'saxena', 'labelme' or 'coco', got '" +
                          format + "'");
  }
  options.classes = std::move(classes);
  options.object_labels = std::move(object_labels);
  options.grasp_labels = std::move(grasp_labels);
  return options;
}

}  // namespace

void bind_dataset(py::module_& m) {
  const LabelledView view_defaults;
  py::class_<LabelledView> view(m, "LabelledView", "One labelled view of one object.");
  define_init(
      view,
      "(self: LabelledView, image: " + image_type + ", mask: " + mask_type + ", label: " + mask_type +
          ", *, class_name: str = '', group: int = 0, source: str = '', image_name: str = '') -> None",
      "image: uint8, RGB or grey. mask, label: uint8 or bool (H, W), > 0 = object, grasp region.",
      py::init([](const py::object& image, const py::object& mask, const py::object& label,
                  std::string class_name, int group, std::string source, std::string image_name) {
        LabelledView result;
        result.source = std::move(source);
        result.class_name = std::move(class_name);
        result.group = group;
        result.image_name = std::move(image_name);
        result.image = image_argument(image, "image");
        result.mask = mask_argument(mask, "mask");
        result.label = mask_argument(label, "label");
        for (cv::Mat* matrix : {&result.image, &result.mask, &result.label}) own(*matrix);
        return result;
      }),
      py::arg("image"), py::arg("mask"), py::arg("label"), py::kw_only(),
      py::arg("class_name") = view_defaults.class_name, py::arg("group") = view_defaults.group,
      py::arg("source") = view_defaults.source, py::arg("image_name") = view_defaults.image_name);
  view.def_readonly("source", &LabelledView::source, "File or scene it comes from.");
  view.def_readonly("class_name", &LabelledView::class_name, "Object family.");
  view.def_readonly("group", &LabelledView::group, "The two views of one scene share a group.");
  view.def_readonly("image_name", &LabelledView::image_name, "Of the image or scene, within its data set.");
  view.def_property_readonly(
      "image", [](const LabelledView& self) { return image_result(self.image); }, "uint8, RGB or grey.");
  def_array<std::uint8_t>(view, "mask", &LabelledView::mask, "(H, W) uint8, > 0 = the object.");
  def_array<std::uint8_t>(view, "label", &LabelledView::label, "(H, W) uint8, > 0 = grasp region.");

  py::class_<LabelledPatches> patches(m, "LabelledPatches", "The patches of a labelled view (III-C).");
  patches.def_readonly("patches", &LabelledPatches::patches);
  def_array<int>(patches, "labels", &LabelledPatches::labels, "(M,) int32, 1 if it overlaps the region.");
  def_array<float>(patches, "label_share", &LabelledPatches::label_share,
                   "(M,) float32 share of the patch's pixels that are labelled.");
  patches.def_readonly("visible_label_share", &LabelledPatches::visible_label_share,
                       "Labelled pixels over object pixels.");

  py::class_<TrainingSet> set(m, "TrainingSet", "Training rows gathered over many views, in order.");
  def_array<float>(set, "features", &TrainingSet::features, "(R, D) float32.");
  def_array<int>(set, "labels", &TrainingSet::labels, "(R,) int32, 0 or 1.");
  def_array<int>(set, "groups", &TrainingSet::groups, "(R,) int32, LabelledView.group.");
  def_array<int>(set, "views", &TrainingSet::views,
                 "(R,) int32, number of the view: each mask of each labelled view is one.");

  m.def(
      "load_dataset",
      [](const std::filesystem::path& path, const std::vector<std::string>& classes, const std::string& views,
         const std::string& format, const std::vector<std::string>& object_labels,
         const std::vector<std::string>& grasp_labels, const std::vector<std::string>& images) {
        DatasetOptions options = dataset_options(format, classes, object_labels, grasp_labels);
        options.images = images;
        options.views = which_views(views);
        return without_gil([&] { return load_dataset(path, options); });
      },
      py::arg("path"), py::kw_only(), py::arg("classes") = std::vector<std::string>(),
      py::arg("views") = "both", py::arg("format") = "detect",
      py::arg("object_labels") = std::vector<std::string>(),
      py::arg("grasp_labels") = std::vector<std::string>(), py::arg("images") = std::vector<std::string>(),
      "The labelled views of a data set (docs/dataset-format.md). classes: only these; empty for all. views: "
      "'left' or 'both'. format: 'graspctx', 'saxena', 'labelme' or 'coco'. object_labels, grasp_labels: "
      "what labelme and COCO call them. images: only these, by LabelledView.image_name; empty for all. "
      "Raises InvalidInput naming the file.");
  m.def(
      "check_dataset",
      [](const std::filesystem::path& path, const std::string& format,
         const std::vector<std::string>& object_labels, const std::vector<std::string>& grasp_labels) {
        const DatasetOptions options = dataset_options(format, {}, object_labels, grasp_labels);
        return without_gil([&] { return check_dataset(path, options).problems; });
      },
      py::arg("path"), py::kw_only(), py::arg("format") = "detect",
      py::arg("object_labels") = std::vector<std::string>(),
      py::arg("grasp_labels") = std::vector<std::string>(),
      "The problems of a data set, one line each, the first 200; empty if it is sound. Options as for "
      "load_dataset.");

  m.def("image_names", &image_names, py::arg("views"),
        "The name of each group's image, for train_model(image_names=...): LabelledView.image_name, or "
        "'image N' "
        "with the group's number where that is empty or may not stand in a model's file.");

  DescriptorOptions descriptor;
  AugmentOptions augment;
  define(
      m, "describe_labelled_view", signature("view: LabelledView", keywords(descriptor), "LabelledPatches"),
      "The patches of a labelled view; a patch is positive if it overlaps the labelled region (III-C).",
      [](const LabelledView& self, const py::kwargs& arguments) {
        DescriptorOptions options;
        read_keywords("describe_labelled_view", arguments, keywords(options));
        return without_gil([&] { return describe_labelled_view(self, options); });
      },
      py::arg("view"));
  define(
      m, "augment_views",
      signature("views: collections.abc.Sequence[LabelledView]", all_keywords(augment), "list[LabelledView]"),
      R"(The views that build_training_set describes (METHOD 5).

Each with its true mask, then its copies with masks that are too large, carry a wedge of the background or are cut off.
degraded_masks: such copies of each view.)",
      [](const std::vector<LabelledView>& views, const py::kwargs& arguments) {
        AugmentOptions options;
        read_keywords("augment_views", arguments, all_keywords(options));
        return without_gil([&] { return augment_views(views, options); });
      },
      py::arg("views"));
  define(
      m, "build_training_set",
      signature("views: collections.abc.Sequence[LabelledView], *, progress: "
                "collections.abc.Callable[[float], None] | None = None",
                all_keywords(augment, descriptor), "TrainingSet"),
      R"(Describe every view with its true mask, and again with masks as imperfect as those met later (METHOD 5).

degraded_masks: such copies of each view. progress: called with the share done; what it raises ends the work.)",
      [](const std::vector<LabelledView>& views, const std::optional<py::function>& progress,
         const py::kwargs& arguments) {
        DescriptorOptions descriptor_options;
        AugmentOptions augment_options;
        read_keywords("build_training_set", arguments, all_keywords(augment_options, descriptor_options));
        const auto report = [&](double share) {
          const py::gil_scoped_acquire acquire;
          if (PyErr_CheckSignals() != 0) throw py::error_already_set();
          if (progress) (*progress)(share);
        };
        return without_gil(
            [&] { return build_training_set(views, descriptor_options, augment_options, report); });
      },
      py::arg("views"), py::kw_only(), py::arg("progress") = py::none());
}

}  // namespace graspctx::python
