#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <map>
#include <optional>

#include "arrays.hpp"
#include "bind.hpp"
#include "graspctx/error.hpp"
#include "graspctx/grasp_model.hpp"
#include "graspctx/io/model_file.hpp"
#include "graspctx/model_choice.hpp"
#include "options.hpp"

namespace graspctx::python {

namespace {

/// The package carries its models beside its modules.
std::vector<std::filesystem::path> model_folders() {
  const auto init = py::module_::import("graspctx").attr("__file__").cast<std::filesystem::path>();
  return {init.parent_path() / "models"};
}

py::bytes bytes_of(const GraspModel& model) {
  const std::vector<std::uint8_t> bytes = without_gil([&] { return model.to_safetensors(); });
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A read-only view of a member of the model.
template <typename Scalar, typename Class, typename Container>
void def_model_array(Class& class_, const char* name, Container GraspModel::*member, const char* doc) {
  class_.def_property_readonly(
      name,
      [member](const py::object& self) {
        return viewed<Scalar>(self.cast<const LoadedModel&>().model.*member, self);
      },
      doc);
}

template <typename Class, typename Value>
void def_model_value(Class& class_, const char* name, Value GraspModel::*member, const char* doc) {
  class_.def_property_readonly(
      name, [member](const LoadedModel& self) { return self.model.*member; }, doc);
}

/// Options of describe_view; those of a base, if there is one, cannot be changed.
DescriptorOptions trained_descriptor(const py::dict& descriptor, const LoadedModel* base) {
  DescriptorOptions options = base != nullptr ? base->model.descriptor : DescriptorOptions();
  const py::dict before = keyword_values(keywords(options));
  read_keywords("train_model(descriptor=...)", descriptor, keywords(options));
  if (base == nullptr) return options;
  for (const auto& [name, value] : keyword_values(keywords(options))) {
    const py::object expected = before[name];
    if (expected.equal(value)) continue;
    throw InvalidInput(py::str("descriptor: {} is {!r}, expected {!r} as in the base")
                           .format(name, value, expected)
                           .cast<std::string>());
  }
  return options;
}

LoadedModel train(const py::object& features, const py::object& labels, const py::object& groups,
                  const std::string& name, std::vector<std::string> classes,
                  const std::map<std::string, std::string>& provenance, const py::dict& descriptor,
                  const std::map<int, std::string>& image_names, const py::object& views,
                  const LoadedModel* base, const std::optional<py::function>& progress,
                  const py::kwargs& arguments) {
  TrainOptions options = base != nullptr ? warm_start(base->model) : TrainOptions();
  read_keywords("train_model", arguments, keywords(options));
  options.image_names = image_names;
  const DescriptorOptions descriptor_options = trained_descriptor(descriptor, base);
  const FeatureRows rows(features, "features");
  const std::vector<int> row_labels = integers_argument(labels, "labels");
  const std::vector<int> row_groups = integers_argument(groups, "groups");
  // Also without a callback of the caller: Ctrl-C is to end a training that takes minutes.
  options.progress = [&](double share, const std::string& what) {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (progress) (*progress)(share, what);
  };
  const bool learns_familiarity = !views.is_none();
  std::vector<int> row_views;
  if (learns_familiarity) row_views = integers_argument(views, "views");
  FamiliarityOptions familiarity_options;
  familiarity_options.seed = options.seed;
  GraspModel model = without_gil([&] {
    std::optional<Familiarity> familiarity;  // first: it takes no time, and refuses bad views
    if (learns_familiarity) {
      familiarity = learn_familiarity(rows.matrix(), row_views, row_groups, familiarity_options);
    }
    GraspModel trained = train_model(rows.matrix(), row_labels, row_groups, options);
    trained.familiarity = std::move(familiarity);
    return trained;
  });
  model.name = name;
  model.classes = std::move(classes);
  model.descriptor = descriptor_options;
  if (base != nullptr) {
    model.provenance["base.name"] = base->model.name;
    model.provenance["base.sha256"] = model_sha256(*base);
  }
  for (const auto& [key, value] : provenance) model.provenance[key] = value;
  return {std::move(model), ""};
}

}  // namespace

std::vector<const LoadedModel*> models_argument(const py::object& value, const char* name) {
  std::vector<const LoadedModel*> models;
  if (py::isinstance<LoadedModel>(value)) {
    models.push_back(value.cast<const LoadedModel*>());
    return models;
  }
  const auto refuse = [&](py::handle found) {
    throw py::type_error(std::string(name) + ": expected a GraspModel or a sequence of them, got " +
                         describe(found));
  };
  if (!py::isinstance<py::list>(value) && !py::isinstance<py::tuple>(value)) refuse(value);
  for (const py::handle item : value) {
    if (!py::isinstance<LoadedModel>(item)) refuse(item);
    models.push_back(item.cast<const LoadedModel*>());
  }
  return models;
}

std::string model_sha256(const LoadedModel& model) {
  if (!model.sha256.empty()) return model.sha256;
  return py::module_::import("hashlib")
      .attr("sha256")(bytes_of(model.model))
      .attr("hexdigest")()
      .cast<std::string>();
}

void bind_grasp_model(py::module_& m) {
  py::class_<LoadedModel> model(m, "GraspModel", R"(The trained classifier (III-C).

C-SVC with an RBF kernel on standardised descriptors, and Platt's sigmoid:
x' = (x − mean) / scale;  f(x) = Σ coefficient_i · exp(−gamma · ‖x' − s_i‖²) − rho;  P = 1 / (1 + exp(A·f + B)).
Made by load_model or train_model.)");
  def_model_value(model, "name", &GraspModel::name, "Its name.");
  def_model_value(model, "classes", &GraspModel::classes, "The object classes it was trained on.");
  def_model_value(model, "provenance", &GraspModel::provenance,
                  "How it was made: command, data set, counts, cross-validation results.");
  model.def_property_readonly(
      "descriptor",
      [](const LoadedModel& self) {
        DescriptorOptions options = self.model.descriptor;
        return keyword_values(keywords(options));
      },
      "The options of describe_view that its features were made with, by name.");
  model.def_property_readonly(
      "dimension", [](const LoadedModel& self) { return self.model.mean.size(); },
      "Columns of its features.");
  model.def_property_readonly("sha256", &model_sha256, "Hexadecimal hash of the model's file.");
  def_model_array<float>(model, "mean", &GraspModel::mean, "(D,) float32.");
  def_model_array<float>(model, "scale", &GraspModel::scale, "(D,) float32, > 0.");
  def_model_array<float>(model, "support_vectors", &GraspModel::support_vectors,
                         "(S, D) float32, standardised.");
  def_model_array<double>(model, "coefficients", &GraspModel::coefficients,
                          "(S,) float64 y_i · α_i, positive class first.");
  def_model_value(
      model, "training_images", &GraspModel::training_images,
      "Names within the data set of the images that support vectors come from; empty if unknown.");
  def_model_array<int>(model, "support_images", &GraspModel::support_images,
                       "(S,) int32 indices of training_images; empty if unknown.");
  def_model_value(model, "svm_c", &GraspModel::svm_c, "C of the SVM.");
  def_model_value(model, "gamma", &GraspModel::gamma, "Of the RBF kernel.");
  def_model_value(model, "rho", &GraspModel::rho, "Bias of the decision value.");
  def_model_value(model, "sigmoid_a", &GraspModel::sigmoid_a, "A of Platt's sigmoid.");
  def_model_value(model, "sigmoid_b", &GraspModel::sigmoid_b, "B of Platt's sigmoid.");

  const std::string features_argument =
      "(self: GraspModel, features: " + float32_type + ") -> " + float64_type;
  define(
      model, "predict_probability", features_argument,
      "P(g = 1 | D) of each row: float32 (M, D) features give (M,) float64. Rows are not copied if "
      "contiguous. "
      "Raises InvalidInput for another width or values that are not finite.",
      [](const LoadedModel& self, const py::object& features) {
        const FeatureRows rows(features, "features");
        return moved<double>(without_gil([&] { return self.model.predict_probability(rows.matrix()); }));
      },
      py::arg("features"));
  define(
      model, "decision_values", features_argument,
      "f(x) of each row: float32 (M, D) features give (M,) float64.",
      [](const LoadedModel& self, const py::object& features) {
        const FeatureRows rows(features, "features");
        return moved<double>(without_gil([&] { return self.model.decision_values(rows.matrix()); }));
      },
      py::arg("features"));
  define(
      model, "familiarity", "(self: GraspModel, features: " + float32_type + ") -> float | None",
      "How much an object looks like what the model was taught, 0 to 1, from the float32 (M, D) descriptors "
      "of "
      "its patches, M > 0: the share of the training views that are as far from the views of other images, "
      "the "
      "object counted among them. None if the model does not know.",
      [](const LoadedModel& self, const py::object& features) -> std::optional<double> {
        const FeatureRows rows(features, "features");
        const auto& familiarity = self.model.familiarity;
        if (!familiarity) return std::nullopt;
        return without_gil([&] { return familiarity->at_distance(familiarity->distance(rows.matrix())); });
      },
      py::arg("features"));
  model.def(
      "save",
      [](const LoadedModel& self, const std::filesystem::path& path) {
        without_gil([&] { save_model(self.model, path); });
      },
      py::arg("path"), "Write a .safetensors file, all or nothing. Raises InvalidInput naming the file.");
  model.def(
      "to_bytes", [](const LoadedModel& self) { return bytes_of(self.model); },
      "The bytes of the model's file.");
  model.def(
      "to_libsvm", [](const LoadedModel& self) { return self.model.to_libsvm(); },
      "libsvm's text format; it takes standardised features.");
  model.def("__repr__", [](const LoadedModel& self) {
    return py::str("GraspModel({!r}, classes={}, {} support vectors × {})")
        .format(self.model.name, self.model.classes, self.model.support_vectors.rows(),
                self.model.support_vectors.cols());
  });
  model.def(py::pickle([](const LoadedModel& self) { return bytes_of(self.model); },
                       [](const py::bytes& state) {
                         const auto text = static_cast<std::string_view>(state);
                         return LoadedModel{
                             GraspModel::from_safetensors(reinterpret_cast<const std::uint8_t*>(text.data()),
                                                          text.size()),
                             ""};
                       }));

  m.def(
      "load_model",
      [](const std::filesystem::path& name_or_path) {
        const std::vector<std::filesystem::path> folders = model_folders();
        return without_gil([&] { return load_model(name_or_path.string(), folders); });
      },
      py::arg("name_or_path"),
      "Load a shipped model by its name ('mug', 'pencil', …), or a .safetensors file. A file is data: "
      "loading "
      "executes nothing. Raises InvalidInput naming the file and what is wrong with it.");
  m.def(
      "shipped_models",
      [] {
        std::vector<std::string> names;
        for (const auto& file : shipped_models(model_folders())) names.push_back(file.stem().string());
        return names;
      },
      "Names of the shipped models.");

  TrainOptions defaults;
  define(
      m, "train_model",
      signature(
          "features: " + float32_type + ", labels: " + integer_type + ", groups: " + integer_type +
              ", *, name: str = '', classes: collections.abc.Sequence[str] = (), provenance: "
              "collections.abc.Mapping[str, str] = {}, descriptor: dict[str, typing.Any] = {}, image_names: "
              "collections.abc.Mapping[int, str] = {}, views: " +
              integer_type +
              " | None = None, base: GraspModel | None = None, progress: "
              "collections.abc.Callable[[float, str], None] | None = None",
          keywords(defaults), "GraspModel"),
      R"(Train a model (III-C): C and γ by cross-validation grouped by image, the sigmoid on held-out images.

features: float32 (M, D). labels: integers (M,), 0 or 1. groups: integers (M,), the image of each row.
name, classes, provenance: stored with the model. descriptor: the options of describe_view that the features
were made with, where they differ from the defaults.
image_names: of the groups; with them the model keeps its training_images, which explain_grasp names.
views: integers (M,), the view of each row, as in TrainingSet.views: the model learns what objects are familiar
from them, GraspModel.familiarity. None: it does not.
base: a model to start from, for few images: its support vectors are trained on together with the rows, which
must be of its descriptor, and never held out; C and γ are its own unless given, more rows of an image count.
progress: called with the share done and what is being done; what it raises ends the training.
gamma_times_dimension: γ = value / D. The search is over all pairs of it and svm_c.
Raises InvalidInput for sizes that differ, other labels, a single class, fewer groups than folds, or features
that are not finite.)",
      &train, py::arg("features"), py::arg("labels"), py::arg("groups"), py::kw_only(),
      py::arg("name") = GraspModel{}.name, py::arg("classes") = GraspModel{}.classes,
      py::arg("provenance") = GraspModel{}.provenance, py::arg("descriptor") = py::dict(),
      py::arg("image_names") = TrainOptions{}.image_names, py::arg("views") = py::none(),
      py::arg("base") = py::none(), py::arg("progress") = py::none());

  py::class_<ModelChoice> choice(m, "ModelChoice", "The model that answers for an object, of several.");
  choice.def_readonly("model", &ModelChoice::model, "Its index.");
  choice.def_readonly("familiarity", &ModelChoice::familiarity, "0 to 1, of the object to that model.");
  choice.def_readonly("familiar", &ModelChoice::familiar, "The object is familiar enough to it.");
  define(
      m, "choose_model",
      "(models: GraspModel | collections.abc.Sequence[GraspModel], features: collections.abc.Sequence[" +
          float32_type + "], min_familiarity: float = " +
          py::repr(py::float_(default_min_familiarity)).cast<std::string>() + ") -> ModelChoice",
      R"(The vote: of the models that an object is familiar enough to, the one with the nearest training view.

If there is none, the one with the nearest training view of all, and `familiar` is False.
features: for each model float32 (M, D), the object's patch descriptors by the model's own descriptor options.
Raises InvalidInput for no models, another number of features, or a model without familiarity.)",
      [](const py::object& models, const std::vector<py::object>& features, double min_familiarity) {
        std::vector<const GraspModel*> asked;
        for (const LoadedModel* loaded : models_argument(models, "models")) asked.push_back(&loaded->model);
        std::vector<FeatureMatrix> rows;
        for (const py::object& array : features) rows.push_back(FeatureRows(array, "features").matrix());
        std::vector<const FeatureMatrix*> pointers;
        for (const FeatureMatrix& matrix : rows) pointers.push_back(&matrix);
        return without_gil([&] { return choose_model(asked, pointers, min_familiarity); });
      },
      py::arg("models"), py::arg("features"), py::arg("min_familiarity") = default_min_familiarity);
}

}  // namespace graspctx::python
