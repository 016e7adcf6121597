#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graspctx/export.hpp"
#include "graspctx/familiarity.hpp"
#include "graspctx/patch_descriptor.hpp"

namespace graspctx {

/// The trained classifier (III-C): C-SVC with an RBF kernel on standardised descriptors, and Platt's sigmoid.
///   x' = (x − mean) / scale;   f(x) = Σ_i coefficient_i · exp(−γ ‖x' − s_i‖²) − ρ;   P = 1 / (1 + exp(A·f +
///   B))
struct GRASPCTX_EXPORT GraspModel {
  std::string name;
  std::vector<std::string> classes;  // the object classes it was trained on
  std::map<std::string, std::string>
      provenance;  // command, data set, counts, versions, cross-validation results
  DescriptorOptions descriptor;

  Eigen::VectorXf mean, scale;  // (D) standardisation, scale > 0
  double svm_c = 0, gamma = 0;
  FeatureMatrix support_vectors;  // (S, D) standardised
  Eigen::VectorXd coefficients;   // (S) y_i · α_i, positive class first
  double rho = 0;
  double sigmoid_a = 0, sigmoid_b = 0;

  // Which image each support vector comes from, for explanations; both empty in a model that does not know.
  std::vector<std::string> training_images;  // names relative to the data set
  std::vector<int> support_images;           // (S) indices of training_images
  std::optional<Familiarity> familiarity;    // what objects it was taught; models need not have it

  /// Throws InvalidInput unless sizes agree and all numbers are finite and in range.
  void check() const;
  /// f(x) of each row (M, D) of unstandardised features.
  Eigen::VectorXd decision_values(const Eigen::Ref<const FeatureMatrix>& features) const;
  /// P(g = 1 | D) of each row (M, D). Throws InvalidInput for another width or non-finite values.
  Eigen::VectorXd predict_probability(const Eigen::Ref<const FeatureMatrix>& features) const;

  /// One safetensors file in memory: a JSON header of string metadata, raw little-endian tensors.
  std::vector<std::uint8_t> to_safetensors() const;
  /// Throws InvalidInput naming what is wrong; nothing is trusted: sizes, bounds, overlaps, finite values.
  static GraspModel from_safetensors(const std::uint8_t* bytes, std::size_t size);
  /// libsvm's text format. It takes standardised features: libsvm_range is the matching `svm-scale -r` file.
  std::string to_libsvm() const;
  std::string libsvm_range() const;
};

/// Whether two models describe a view alike, so that it need be described only once.
GRASPCTX_EXPORT bool same_descriptor(const GraspModel& a, const GraspModel& b);

struct GRASPCTX_EXPORT TrainOptions {
  std::vector<double> svm_c{1, 3, 10};
  std::vector<double> gamma_times_dimension{0.5, 1};  // γ = value / D
  int folds = 5;                                      // grouped by image
  int max_positives_per_group = 24;  // rows of each image kept to train the SVM; the sigmoid sees all rows
  int max_negatives_per_group = 48;
  int max_rows = 12000;        // of all images together: fewer of each where there are many, 1 and 2 at least
  int max_search_rows = 4000;  // whole groups, for the search over C and γ
  std::uint32_t seed = 1;
  std::map<int, std::string> image_names;  // of the groups; with them the model keeps its training_images
  const GraspModel* base = nullptr;        // start from it (warm_start); not owned, must outlive the training
  std::vector<double> learning_curve;      // shares of the images, over 0 and under 1; none by default
  std::function<void(double share, const std::string& what)> progress;  // may be empty
  void check() const;
};

/// Options that start from a trained model: its support vectors, with its answers as labels, are trained on
/// together with the given rows and never held out. C and γ are the base's, not searched. The features must
/// be of the base's descriptor.
GRASPCTX_EXPORT TrainOptions warm_start(const GraspModel& base);

/// Train a model. features (M, D); labels (M) 0 or 1; groups (M) index of the image each row comes from.
/// C and γ by cross-validation grouped by image, the sigmoid on grouped held-out folds with all their
/// patches. The descriptor options, name, classes and provenance are the caller's to fill in; provenance
/// holds the training's own entries. Throws InvalidInput for sizes that differ, labels other than 0 and 1, a
/// single class, fewer groups than folds, non-finite features, or image names that lack a group.
GRASPCTX_EXPORT GraspModel train_model(const Eigen::Ref<const FeatureMatrix>& features,
                                       const std::vector<int>& labels, const std::vector<int>& groups,
                                       const TrainOptions& options = {});

/// One step of a learning curve: models that were trained on some of the images.
struct LearningStep {
  int images = 0;                              // mean over the folds
  std::vector<double> held_out_probabilities;  // (M)
};

/// A model, and what its cross-validation answered for rows whose images were held out.
struct Training {
  GraspModel model;
  std::vector<double> held_out_probabilities;  // (M) of each row; SVM and sigmoid fitted to other folds
  int images_of_folds = 0;                     // that the models of the folds were trained on, mean
  std::vector<LearningStep> learning_curve;    // TrainOptions::learning_curve, in order
};

/// train_model, with the answers for held-out rows. The model is the same, byte for byte.
GRASPCTX_EXPORT Training train_and_validate(const Eigen::Ref<const FeatureMatrix>& features,
                                            const std::vector<int>& labels, const std::vector<int>& groups,
                                            const TrainOptions& options = {});

}  // namespace graspctx
