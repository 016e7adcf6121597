#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "graspctx/contour.hpp"
#include "graspctx/dataset.hpp"
#include "graspctx/detector.hpp"
#include "graspctx/export.hpp"
#include "graspctx/grasp_model.hpp"

namespace graspctx {

struct GRASPCTX_EXPORT ExplanationOptions {
  int max_images = 5;  // nearest training images, of each label
  void check() const;
};

/// A patch of a training image.
struct TrainingPatch {
  FovealView view;
  cv::Point2f centre_px;  // of the view
};

/// A training image as the model remembers it: the support vectors that it gave, of one label.
struct NearImage {
  std::string name;                    // of GraspModel::training_images
  int support_vector = 0;              // the nearest one: its row in GraspModel::support_vectors
  double similarity = 0;               // K(x, s) = exp(−γ ‖x' − s‖²) of that one, 0 to 1
  int support_vectors = 0;             // how many
  double contribution = 0;             // to f, of all of them: Σ coefficient · K
  std::optional<TrainingPatch> patch;  // the nearest one's, once find_training_patches has found it
};

/// What the decision value f of one patch rests on. An effect is by how much f falls when something is taken
/// away: it speaks for a grasping point if positive, against if negative.
struct PatchExplanation {
  cv::Point2f centre_px;              // of the view
  double decision_value = 0;          // f(x)
  double probability = 0;             // P(g = 1 | D) in this view
  std::vector<double> point_effects;  // (N) each contour sample left out
  Eigen::VectorXd bin_effects;  // (3·bins) each column of the shape context at its training mean, x' = 0
  std::optional<double> other_effect;  // all columns behind those of the shape context at their means
  std::vector<double> ring_radii_px;   // outer radius of each ring of the log-polar histograms
  std::vector<NearImage> graspable, not_graspable;  // by label, the most similar first; empty if the model
                                                    // does not know its training images
};

/// Why the model thinks of a patch as it does. contour: of the patch's view; feature (D): the patch's row of
/// describe_view. A sample is left out exactly, from the windows that hold it and from the histograms of all
/// others; only the mean pairwise distance stays as it is. Columns behind the 3·bins of the shape context do
/// not change with it. Bins are looked at one by one: their effects do not add up to f. Throws InvalidInput
/// if the feature is not of that patch and that contour, or not of the model's dimension.
GRASPCTX_EXPORT PatchExplanation explain_patch(const Contour& contour, const cv::Point2f& centre_px,
                                               const Eigen::Ref<const Eigen::RowVectorXf>& feature,
                                               const GraspModel& model,
                                               const ExplanationOptions& options = {});

/// A detected grasp, with what was seen there.
struct GraspExplanation {
  int object_id = 0;
  GraspConfiguration grasp;
  FovealView view;  // the left one
  Contour contour;  // of the view
  DescriptorOptions descriptor;
  PatchExplanation patch;  // in the left view
};

/// Why there is a grasp: its patch in the left view. model: the one that the detection was made with. rank:
/// from 1. Throws InvalidInput if the object has no grasp of that rank, or the model is another.
GRASPCTX_EXPORT GraspExplanation explain_grasp(const DetectedObject& object, const GraspModel& model,
                                               int rank = 1, const ExplanationOptions& options = {});

/// The same explanation with NearImage::patch: the patch of the training image whose descriptor is the
/// nearest to the support vector (its very patch, but for those of degraded masks). views: of the training
/// data, at least of the images named. Throws InvalidInput if one of them is missing.
GRASPCTX_EXPORT PatchExplanation find_training_patches(const PatchExplanation& explanation,
                                                       const GraspModel& model,
                                                       const std::vector<LabelledView>& views);

}  // namespace graspctx
