#include "graspctx/grasp_model.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <system_error>
#include <type_traits>

#include "detail/image_name.hpp"
#include "detail/number_text.hpp"
#include "detail/safetensors.hpp"
#include "detail/sigmoid.hpp"
#include "graspctx/error.hpp"

namespace graspctx {

namespace {

constexpr const char* file_format = "graspctx.grasp_model";
constexpr int format_version = 1;
constexpr int max_dimension = 4096;
constexpr double max_magnitude = 1e9;  // of C, γ, ρ, A and B: nothing in f or P can overflow
constexpr std::size_t max_tensor_length = 10000000;

using detail::is_printable;
using Text = Eigen::Matrix<std::uint8_t, Eigen::Dynamic, 1>;

void require(bool condition, const std::string& message) {
  if (!condition) throw InvalidInput("model: " + message);
}

/// The part of a model that prediction uses.
void check_classifier(const GraspModel& model) {
  const Eigen::Index dimension = model.mean.size();
  const std::string features = std::to_string(dimension) + " features";
  require(dimension > 0 && dimension <= max_dimension,
          "expected 1 to " + std::to_string(max_dimension) + " features, got " + std::to_string(dimension));
  require(model.scale.size() == dimension,
          "the mean has " + features + ", the scale " + std::to_string(model.scale.size()));
  require(model.support_vectors.cols() == dimension, "the mean has " + features + ", the support vectors " +
                                                         std::to_string(model.support_vectors.cols()));
  require(model.support_vectors.rows() > 0, "it has no support vectors");
  require(model.coefficients.size() == model.support_vectors.rows(),
          "it has " + std::to_string(model.support_vectors.rows()) + " support vectors, but " +
              std::to_string(model.coefficients.size()) + " coefficients");
  require(model.mean.allFinite(), "the mean must be finite");
  require(model.scale.allFinite() && (model.scale.array() > 0).all(),
          "the scale must be finite and positive");
  require(model.support_vectors.allFinite(), "the support vectors must be finite");
  const auto in_range = [](double value) { return std::abs(value) <= max_magnitude; };  // not for NaN
  require(in_range(model.svm_c) && model.svm_c > 0, "C must be positive and at most 1e9");
  require(in_range(model.gamma) && model.gamma > 0, "gamma must be positive and at most 1e9");
  require(in_range(model.rho), "rho must be finite and at most 1e9");
  require(in_range(model.sigmoid_a) && in_range(model.sigmoid_b),
          "the sigmoid's A and B must be finite and at most 1e9");
  bool negative = false;
  for (const double coefficient : model.coefficients) {
    require(coefficient != 0 && std::abs(coefficient) <= model.svm_c,
            "the coefficients must not be zero and lie between -C and C");
    require(coefficient < 0 || !negative, "the support vectors of the positive class must come first");
    negative = coefficient < 0;
  }
}

/// The names of the training images as one text, a line each.
std::string lines_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += name + '\n';
  return text;
}

std::vector<std::string> names_in(const Text& text) {
  std::vector<std::string> names(1);
  for (const std::uint8_t c : text) {
    if (c == '\n') {
      names.emplace_back();
    } else {
      names.back() += static_cast<char>(c);
    }
  }
  require(names.back().empty(), "the names of its training images must end with a line feed");
  names.pop_back();
  return names;
}

void check_training_images(const GraspModel& model) {
  const std::vector<std::string>& names = model.training_images;
  if (names.empty() && model.support_images.empty()) return;
  const auto vectors = static_cast<std::size_t>(model.support_vectors.rows());
  require(model.support_images.size() == vectors, "it has " + std::to_string(vectors) +
                                                      " support vectors, but knows the images of " +
                                                      std::to_string(model.support_images.size()));
  std::vector<bool> is_used(names.size(), false);
  for (const int image : model.support_images) {
    require(
        image >= 0 && static_cast<std::size_t>(image) < names.size(),
        "a support vector comes from image " + std::to_string(image) + " of " + std::to_string(names.size()));
    is_used[static_cast<std::size_t>(image)] = true;
  }
  require(std::all_of(is_used.begin(), is_used.end(), [](bool used) { return used; }),
          "each of its training images must have a support vector");
  for (const std::string& name : names) {
    require(detail::is_image_name(name), "the names of its training images must be printable UTF-8 of 1 to " +
                                             std::to_string(detail::max_image_name_bytes) +
                                             " bytes, and relative");
  }
  require(lines_of(names).size() <= max_tensor_length, "the names of its training images are too long");
}

// ---------------------------------------------------------------------------------------------- the file

std::string text_of(double value) {
  return detail::number_text(value);
}
std::string text_of(int value) {
  return std::to_string(value);
}
std::string text_of(bool value) {
  return value ? "true" : "false";
}

/// Reads the numbers out of the metadata, each once, and knows which were never asked for.
class MetadataReader {
 public:
  explicit MetadataReader(std::map<std::string, std::string> metadata) : metadata_(std::move(metadata)) {}

  std::string take(const std::string& key) {
    const auto found = metadata_.find(key);
    if (found == metadata_.end()) throw InvalidInput("model file: the metadata lack '" + key + "'");
    std::string value = std::move(found->second);
    metadata_.erase(found);
    return value;
  }

  bool holds(const std::string& key) const { return metadata_.count(key) > 0; }
  void take(const std::string& key, std::string& value) { value = take(key); }
  void take(const std::string& key, bool& value) {
    const std::string text = take(key);
    if (text != "true" && text != "false") fail(key, text, "true or false");
    value = text == "true";
  }
  void take(const std::string& key, double& value) { parse(key, "a finite number", value); }
  void take(const std::string& key, int& value) {
    parse(key, "a whole number", value);
    if (std::abs(static_cast<long long>(value)) > 1000000) {
      fail(key, std::to_string(value), "at most a million");
    }
  }

  /// All entries whose keys start with the prefix, without it.
  std::map<std::string, std::string> take_all(const std::string& prefix) {
    std::map<std::string, std::string> entries;
    for (auto entry = metadata_.lower_bound(prefix);
         entry != metadata_.end() && entry->first.compare(0, prefix.size(), prefix) == 0;) {
      entries[entry->first.substr(prefix.size())] = std::move(entry->second);
      entry = metadata_.erase(entry);
    }
    return entries;
  }

  void expect_nothing_left() const {
    if (metadata_.empty()) return;
    const std::string& key = metadata_.begin()->first;
    throw InvalidInput("model file: the metadata hold an unknown entry" +
                       (is_printable(key) ? " '" + key.substr(0, 60) + "'" : std::string()));
  }

 private:
  template <typename Number>
  void parse(const std::string& key, const char* expected, Number& value) {
    const std::string text = take(key);
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);  // independent of the locale
    if (error != std::errc() || stop != end || !std::isfinite(static_cast<double>(value))) {
      fail(key, text, expected);
    }
  }
  [[noreturn]] static void fail(const std::string& key, const std::string& text, const char* expected) {
    throw InvalidInput("model file: '" + key + "' is " +
                       (is_printable(text) ? "'" + text.substr(0, 60) + "'" : "not printable") +
                       ": expected " + expected);
  }

  std::map<std::string, std::string> metadata_;
};

/// Entries that only those models have that make use of them: files of before these options lack them.
constexpr const char* refine_entry = "descriptor.fovea.refine_mask";
constexpr const char* outline_entry = "descriptor.shape_context.outline_px";

/// Tensors of those models that tell what is familiar.
constexpr const char* views_tensor = "familiarity.views";
constexpr const char* distances_tensor = "familiarity.held_out_distances";

/// Every number outside the tensors, by name: written and read by the same list.
template <typename Model, typename Visit>
void visit_numbers(Model& model, const Visit& visit) {
  auto& descriptor = model.descriptor;
  visit("descriptor.fovea.object_px", descriptor.fovea.object_px);
  visit("descriptor.fovea.margin_px", descriptor.fovea.margin_px);
  visit(refine_entry, descriptor.fovea.refine_mask);
  visit("descriptor.contour.canny_low", descriptor.contour.canny_low);
  visit("descriptor.contour.canny_high", descriptor.contour.canny_high);
  visit("descriptor.contour.samples", descriptor.contour.samples);
  visit("descriptor.contour.mask_margin_px", descriptor.contour.mask_margin_px);
  visit("descriptor.shape_context.angular_bins", descriptor.shape_context.angular_bins);
  visit("descriptor.shape_context.radial_bins", descriptor.shape_context.radial_bins);
  visit("descriptor.shape_context.inner_radius", descriptor.shape_context.inner_radius);
  visit("descriptor.shape_context.outer_radius", descriptor.shape_context.outer_radius);
  visit("descriptor.shape_context.relative_to_gradient", descriptor.shape_context.relative_to_gradient);
  visit(outline_entry, descriptor.shape_context.outline_px);
  visit("descriptor.patch.patch_px", descriptor.patch.patch_px);
  visit("descriptor.patch.windows_patches.0", descriptor.patch.windows_patches[0]);
  visit("descriptor.patch.windows_patches.1", descriptor.patch.windows_patches[1]);
  visit("descriptor.patch.windows_patches.2", descriptor.patch.windows_patches[2]);
  visit("svm.c", model.svm_c);
  visit("svm.gamma", model.gamma);
  visit("svm.rho", model.rho);
  visit("sigmoid.a", model.sigmoid_a);
  visit("sigmoid.b", model.sigmoid_b);
}

template <typename Number>
constexpr const char* dtype_of() {
  if (std::is_same_v<Number, double>) return "F64";
  if (std::is_same_v<Number, float>) return "F32";
  return std::is_same_v<Number, std::int32_t> ? "I32" : "U8";
}

template <typename Matrix>
detail::Tensor tensor_of(const Matrix& matrix, std::vector<std::uint64_t> shape) {
  using Number = typename Matrix::Scalar;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(matrix.data());
  return {dtype_of<Number>(),
          std::move(shape),
          {bytes, bytes + static_cast<std::size_t>(matrix.size()) * sizeof(Number)}};
}

/// A tensor of the given type with one or two dimensions, as a matrix.
template <typename Matrix>
Matrix matrix_of(detail::Safetensors& file, const std::string& name) {
  using Number = typename Matrix::Scalar;
  constexpr bool vector = Matrix::ColsAtCompileTime == 1;
  const std::string dtype = dtype_of<Number>();
  const auto found = file.tensors.find(name);
  if (found == file.tensors.end()) throw InvalidInput("model file: the tensor '" + name + "' is missing");
  const detail::Tensor tensor = std::move(found->second);
  file.tensors.erase(found);
  if (tensor.dtype != dtype || tensor.shape.size() != (vector ? 1 : 2)) {
    throw InvalidInput("model file: expected '" + name + "' as " + dtype + " of " + (vector ? "1" : "2") +
                       " dimensions, got " + tensor.dtype + " of " + std::to_string(tensor.shape.size()));
  }
  for (const std::uint64_t length : tensor.shape) {
    if (length == 0 || length > max_tensor_length) {
      throw InvalidInput("model file: '" + name + "' has a dimension of " + std::to_string(length) +
                         ": expected 1 to " + std::to_string(max_tensor_length));
    }
  }
  Matrix matrix(static_cast<Eigen::Index>(tensor.shape[0]),
                static_cast<Eigen::Index>(vector ? 1 : tensor.shape[1]));
  std::memcpy(matrix.data(), tensor.bytes.data(), tensor.bytes.size());
  return matrix;
}

}  // namespace

void GraspModel::check() const {
  check_classifier(*this);
  descriptor.check();
  require(descriptor.dimension() == mean.size(), "its descriptor has " +
                                                     std::to_string(descriptor.dimension()) +
                                                     " dimensions, its mean " + std::to_string(mean.size()));
  if (familiarity) {
    familiarity->check();
    require(familiarity->views.cols() == mean.size(), "its mean has " + std::to_string(mean.size()) +
                                                          " features, its training views " +
                                                          std::to_string(familiarity->views.cols()));
  }
  require(is_printable(name), "its name must not hold control characters");
  for (const std::string& class_name : classes) {
    require(!class_name.empty() && is_printable(class_name),
            "its class names must be neither empty nor hold control characters");
  }
  for (const auto& [key, value] : provenance) {
    require(!key.empty() && is_printable(key) && is_printable(value),
            "its provenance must hold neither an empty key nor control characters");
  }
  check_training_images(*this);
}

Eigen::VectorXd GraspModel::decision_values(const Eigen::Ref<const FeatureMatrix>& features) const {
  check_classifier(*this);
  if (features.cols() != mean.size()) {
    throw InvalidInput("features: the model takes " + std::to_string(mean.size()) + " columns, got " +
                       std::to_string(features.cols()));
  }
  if (!features.allFinite()) throw InvalidInput("features: all values must be finite");

  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const RowMajor vectors = support_vectors.cast<double>();
  const Eigen::RowVectorXd shift = mean.cast<double>(), unit = scale.cast<double>();
  constexpr Eigen::Index block_rows = 32;  // rows that stay in the cache while the vectors pass by
  RowMajor block(block_rows, features.cols());
  Eigen::VectorXd values = Eigen::VectorXd::Constant(features.rows(), -rho);
  for (Eigen::Index first = 0; first < features.rows(); first += block_rows) {
    const Eigen::Index rows = std::min(block_rows, features.rows() - first);
    for (Eigen::Index row = 0; row < rows; ++row) {
      block.row(row) = (features.row(first + row).cast<double>() - shift).cwiseQuotient(unit);
    }
    for (Eigen::Index i = 0; i < vectors.rows(); ++i) {
      for (Eigen::Index row = 0; row < rows; ++row) {
        const double squared_distance = (block.row(row) - vectors.row(i)).squaredNorm();
        values[first + row] += coefficients[i] * std::exp(-gamma * squared_distance);
      }
    }
  }
  return values;
}

Eigen::VectorXd GraspModel::predict_probability(const Eigen::Ref<const FeatureMatrix>& features) const {
  Eigen::VectorXd values = decision_values(features);
  for (double& value : values) value = detail::logistic(sigmoid_a * value + sigmoid_b);
  return values;
}

std::vector<std::uint8_t> GraspModel::to_safetensors() const {
  check();
  detail::Safetensors file;
  file.metadata["format"] = file_format;
  file.metadata["format_version"] = text_of(format_version);
  file.metadata["name"] = name;
  for (std::size_t i = 0; i < classes.size(); ++i) file.metadata["class." + std::to_string(i)] = classes[i];
  for (const auto& [key, value] : provenance) file.metadata["provenance." + key] = value;
  visit_numbers(*this, [&](const char* key, const auto& value) { file.metadata[key] = text_of(value); });
  if (!descriptor.fovea.refine_mask) file.metadata.erase(refine_entry);
  if (descriptor.shape_context.outline_px == 0) file.metadata.erase(outline_entry);
  const std::uint64_t dimension = mean.size(), vectors = support_vectors.rows();
  file.tensors["mean"] = tensor_of(mean, {dimension});
  file.tensors["scale"] = tensor_of(scale, {dimension});
  file.tensors["support_vectors"] = tensor_of(support_vectors, {vectors, dimension});
  file.tensors["coefficients"] = tensor_of(coefficients, {vectors});
  if (!training_images.empty()) {
    const std::string names = lines_of(training_images);
    file.tensors["training_images"] = {
        dtype_of<std::uint8_t>(), {names.size()}, {names.begin(), names.end()}};
    file.tensors["support_images"] =
        tensor_of(Eigen::Map<const Eigen::VectorXi>(support_images.data(), coefficients.size()), {vectors});
  }
  if (familiarity) {
    const std::uint64_t views = familiarity->views.rows();
    file.tensors[views_tensor] = tensor_of(familiarity->views, {views, dimension});
    file.tensors[distances_tensor] = tensor_of(familiarity->held_out_distances, {views});
  }
  return detail::write_safetensors(file);
}

GraspModel GraspModel::from_safetensors(const std::uint8_t* bytes, std::size_t size) {
  detail::Safetensors file = detail::read_safetensors(bytes, size);
  MetadataReader metadata(std::move(file.metadata));
  if (metadata.take("format") != file_format) {
    throw InvalidInput(std::string("model file: expected the format '") + file_format + "'");
  }
  int version = 0;
  metadata.take("format_version", version);
  if (version != format_version) {
    throw InvalidInput("model file: format version " + std::to_string(version) + " is unknown: expected " +
                       std::to_string(format_version));
  }
  GraspModel model;
  metadata.take("name", model.name);
  std::map<std::string, std::string> classes = metadata.take_all("class.");
  for (std::size_t i = 0; i < classes.size(); ++i) {
    const auto found = classes.find(std::to_string(i));
    if (found == classes.end()) throw InvalidInput("model file: the classes must be numbered from 0");
    model.classes.push_back(found->second);
  }
  model.provenance = metadata.take_all("provenance.");
  model.descriptor.fovea.refine_mask = false;
  model.descriptor.shape_context.outline_px = 0;
  visit_numbers(model, [&](const char* key, auto& value) {
    const bool optional = key == std::string(refine_entry) || key == std::string(outline_entry);
    if (!optional || metadata.holds(key)) metadata.take(key, value);
  });
  metadata.expect_nothing_left();

  model.mean = matrix_of<Eigen::VectorXf>(file, "mean");
  model.scale = matrix_of<Eigen::VectorXf>(file, "scale");
  model.support_vectors = matrix_of<FeatureMatrix>(file, "support_vectors");
  model.coefficients = matrix_of<Eigen::VectorXd>(file, "coefficients");
  // Files of before explanations do not have them.
  if (file.tensors.count("training_images") + file.tensors.count("support_images") > 0) {
    model.training_images = names_in(matrix_of<Text>(file, "training_images"));
    const auto images = matrix_of<Eigen::VectorXi>(file, "support_images");
    model.support_images.assign(images.begin(), images.end());
  }
  // Files of before that, and models without it, have neither.
  if (file.tensors.count(views_tensor) + file.tensors.count(distances_tensor) > 0) {
    model.familiarity.emplace();
    model.familiarity->views = matrix_of<FeatureMatrix>(file, views_tensor);
    model.familiarity->held_out_distances = matrix_of<Eigen::VectorXd>(file, distances_tensor);
  }
  if (!file.tensors.empty()) throw InvalidInput("model file: it holds an unknown tensor");
  model.check();
  return model;
}

bool same_descriptor(const GraspModel& a, const GraspModel& b) {
  const auto text = [](const GraspModel& model) {
    std::string entries;
    visit_numbers(model, [&](const std::string& key, const auto& value) {
      if (key.rfind("descriptor.", 0) == 0) entries += key + "=" + text_of(value) + "\n";
    });
    return entries;
  };
  return text(a) == text(b);
}

std::string GraspModel::to_libsvm() const {
  check_classifier(*this);
  const auto positives = (coefficients.array() > 0).count();
  std::string text = "svm_type c_svc\nkernel_type rbf\ngamma " + text_of(gamma) + "\nnr_class 2\ntotal_sv " +
                     std::to_string(coefficients.size()) + "\nrho " + text_of(rho) + "\nlabel 1 0\nprobA " +
                     text_of(sigmoid_a) + "\nprobB " + text_of(sigmoid_b) + "\nnr_sv " +
                     std::to_string(positives) + " " + std::to_string(coefficients.size() - positives) +
                     "\nSV\n";
  for (Eigen::Index row = 0; row < support_vectors.rows(); ++row) {
    text += text_of(coefficients[row]);
    for (Eigen::Index i = 0; i < support_vectors.cols(); ++i) {
      text += " " + std::to_string(i + 1) + ":" + text_of(static_cast<double>(support_vectors(row, i)));
    }
    text += " \n";
  }
  return text;
}

std::string GraspModel::libsvm_range() const {
  check_classifier(*this);
  // svm-scale maps [minimum, maximum] linearly to [lower, upper]: [mean, mean + scale] to [0, 1].
  std::string text = "x\n0 1\n";
  for (Eigen::Index i = 0; i < mean.size(); ++i) {
    const double lower = mean[i], upper = lower + scale[i];
    text += std::to_string(i + 1) + " " + text_of(lower) + " " + text_of(upper) + "\n";
  }
  return text;
}

}  // namespace graspctx
