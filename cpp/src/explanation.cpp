#include "graspctx/explanation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "detail/check.hpp"
#include "detail/log_polar.hpp"
#include "detail/patch_window.hpp"
#include "detail/sigmoid.hpp"

namespace graspctx {

namespace {

/// The histograms of all samples, the samples in a patch's windows, and the sums of their histograms.
struct Windows {
  FeatureMatrix contexts;
  std::array<std::vector<std::size_t>, 3> samples;
  std::array<Eigen::RowVectorXf, 3> sums;
};

Windows sum_windows(const Contour& contour, const cv::Point2f& centre_px, const DescriptorOptions& options) {
  Windows windows;
  windows.contexts =
      shape_contexts(contour.points, options.shape_context, contour.gradients_rad, contour.border_px);
  for (std::size_t scale = 0; scale < 3; ++scale) {
    windows.sums[scale].setZero(options.shape_context.bins());
    const int side_px = options.patch.windows_patches[scale] * options.patch.patch_px;
    for (std::size_t i = 0; i < contour.points.size(); ++i) {
      if (!detail::is_in_window(contour.points[i] - centre_px, side_px)) continue;
      windows.samples[scale].push_back(i);
      windows.sums[scale] += windows.contexts.row(static_cast<Eigen::Index>(i));
    }
  }
  return windows;
}

/// The histogram of a window without one sample: neither as its member nor as counted by the others.
Eigen::RowVectorXf without_sample(const Windows& windows, std::size_t scale, std::size_t left_out,
                                  const detail::LogPolarBins& bins) {
  Eigen::RowVectorXf histogram = windows.sums[scale];
  for (const std::size_t from : windows.samples[scale]) {
    if (from == left_out) histogram -= windows.contexts.row(static_cast<Eigen::Index>(left_out));
    bins.visit(from, left_out, [&](int column) { histogram[column] -= 1; });
  }
  detail::normalise(histogram);
  return histogram;
}

/// The patch's feature without each sample in turn.
FeatureMatrix leave_one_out(const Contour& contour, const Windows& windows, const Eigen::RowVectorXf& feature,
                            const DescriptorOptions& options, const detail::LogPolarBins& bins) {
  const Eigen::Index width = options.shape_context.bins();
  const std::size_t count = contour.points.size();
  FeatureMatrix rows = feature.replicate(static_cast<Eigen::Index>(count), 1);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t scale = 0; scale < 3; ++scale) {
      rows.row(static_cast<Eigen::Index>(i)).segment(static_cast<Eigen::Index>(scale) * width, width) =
          without_sample(windows, scale, i, bins);
    }
  }
  return rows;
}

/// The windows must be those that the feature was made of; otherwise effects would be of something else.
void check_feature(const Eigen::RowVectorXf& feature, const Windows& windows) {
  Eigen::Index first = 0;
  for (const Eigen::RowVectorXf& sum : windows.sums) {
    Eigen::RowVectorXf histogram = sum;
    detail::normalise(histogram);
    const float difference = (feature.segment(first, sum.size()) - histogram).cwiseAbs().maxCoeff();
    if (!(difference <= 1e-4f)) {
      throw InvalidInput(
          "explanation: the feature is not that of the patch, expected its row of describe_view");
    }
    first += sum.size();
  }
}

/// Kernel values of the support vectors.
Eigen::VectorXd similarities(const GraspModel& model, const Eigen::RowVectorXf& feature) {
  const Eigen::RowVectorXd standardised = (feature.cast<double>() - model.mean.cast<double>().transpose())
                                              .cwiseQuotient(model.scale.cast<double>().transpose());
  Eigen::VectorXd values(model.support_vectors.rows());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    values[i] =
        std::exp(-model.gamma * (standardised - model.support_vectors.row(i).cast<double>()).squaredNorm());
  }
  return values;
}

/// The images that gave support vectors of one label, the most similar first.
std::vector<NearImage> nearest_images(const GraspModel& model, const Eigen::VectorXd& similarity,
                                      bool graspable, int max_images) {
  std::map<int, NearImage> by_image;
  if (model.support_images.empty()) return {};
  for (Eigen::Index i = 0; i < similarity.size(); ++i) {
    if ((model.coefficients[i] > 0) != graspable) continue;
    NearImage& image = by_image[model.support_images.at(static_cast<std::size_t>(i))];
    if (image.support_vectors == 0 || similarity[i] > image.similarity) {
      image.support_vector = static_cast<int>(i);
      image.similarity = similarity[i];
    }
    ++image.support_vectors;
    image.contribution += model.coefficients[i] * similarity[i];
  }
  std::vector<NearImage> images;
  for (auto& [index, image] : by_image) {
    image.name = model.training_images.at(static_cast<std::size_t>(index));
    images.push_back(std::move(image));
  }
  std::stable_sort(images.begin(), images.end(),
                   [](const NearImage& a, const NearImage& b) { return a.similarity > b.similarity; });
  if (images.size() > static_cast<std::size_t>(max_images)) {
    images.resize(static_cast<std::size_t>(max_images));
  }
  return images;
}

/// The patch of the views of the named image that is the nearest to a support vector.
TrainingPatch nearest_patch(const NearImage& image, const GraspModel& model,
                            const std::vector<LabelledView>& views) {
  std::optional<TrainingPatch> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const LabelledView& labelled : views) {
    if (labelled.image_name != image.name) continue;
    const FovealView view = foveal_view(labelled.image, labelled.mask, model.descriptor.fovea);
    const PatchDescriptors patches = describe_view(view, model.descriptor);
    for (Eigen::Index row = 0; row < patches.features.rows(); ++row) {
      const double distance =
          ((patches.features.row(row) - model.mean.transpose()).cwiseQuotient(model.scale.transpose()) -
           model.support_vectors.row(image.support_vector))
              .cast<double>()
              .squaredNorm();
      if (distance >= least) continue;
      least = distance;
      nearest = TrainingPatch{view, patches.centres_px[static_cast<std::size_t>(row)]};
    }
  }
  if (!nearest) throw InvalidInput("training data: they lack the image '" + image.name + "'");
  return *nearest;
}

}  // namespace

void ExplanationOptions::check() const {
  detail::require_option(max_images >= 1 && max_images <= 1000, "max_images must be 1 to 1000");
}

PatchExplanation explain_patch(const Contour& contour, const cv::Point2f& centre_px,
                               const Eigen::Ref<const Eigen::RowVectorXf>& feature, const GraspModel& model,
                               const ExplanationOptions& options) {
  options.check();
  const DescriptorOptions& descriptor = model.descriptor;
  descriptor.check();
  const Eigen::RowVectorXf row = feature;
  PatchExplanation explanation;
  explanation.centre_px = centre_px;
  explanation.decision_value = model.decision_values(row)[0];
  const double f = explanation.decision_value;
  explanation.probability = detail::logistic(model.sigmoid_a * f + model.sigmoid_b);
  const Eigen::Index shape_columns = 3 * descriptor.shape_context.bins();
  if (row.size() < shape_columns) {
    throw InvalidInput("explanation: expected a feature of at least " + std::to_string(shape_columns) +
                       " columns, got " + std::to_string(row.size()));
  }

  const Windows windows = sum_windows(contour, centre_px, descriptor);
  check_feature(row, windows);
  const detail::LogPolarBins bins(contour.points, descriptor.shape_context, contour.gradients_rad,
                                  contour.border_px);
  explanation.ring_radii_px = bins.ring_radii_px();
  const Eigen::VectorXd without =
      model.decision_values(leave_one_out(contour, windows, row, descriptor, bins));
  for (const double value : without) explanation.point_effects.push_back(f - value);

  // Each bin at its training mean in turn; in the last row all columns that are no shape context.
  FeatureMatrix at_mean = row.replicate(shape_columns + 1, 1);
  at_mean.topLeftCorner(shape_columns, shape_columns).diagonal() = model.mean.head(shape_columns);
  const Eigen::Index other_columns = row.size() - shape_columns;
  at_mean.bottomRightCorner(1, other_columns) = model.mean.tail(other_columns).transpose();
  const Eigen::VectorXd effects = (f - model.decision_values(at_mean).array()).matrix();
  explanation.bin_effects = effects.head(shape_columns);
  if (other_columns > 0) explanation.other_effect = effects[shape_columns];

  const Eigen::VectorXd similarity = similarities(model, row);
  explanation.graspable = nearest_images(model, similarity, true, options.max_images);
  explanation.not_graspable = nearest_images(model, similarity, false, options.max_images);
  return explanation;
}

GraspExplanation explain_grasp(const DetectedObject& object, const GraspModel& model, int rank,
                               const ExplanationOptions& options) {
  model.check();
  const std::string name = "object " + std::to_string(object.id);
  const auto count = static_cast<int>(object.grasps.size());
  if (rank < 1 || rank > count) {
    throw InvalidInput(name + ": has " + std::to_string(count) + (count == 1 ? " grasp" : " grasps") +
                       ", expected a rank from 1 to that, got " + std::to_string(rank));
  }
  const GraspConfiguration& grasp = object.grasps[static_cast<std::size_t>(rank - 1)];
  const ObjectIntermediates& seen = object.intermediates;
  const PatchDescriptors& patches = seen.patches;
  if (grasp.patch < 0 || grasp.patch >= patches.features.rows()) {
    throw InvalidInput(name + ": its grasp is of patch " + std::to_string(grasp.patch) + " of " +
                       std::to_string(patches.features.rows()));
  }
  GraspExplanation explanation;
  explanation.object_id = object.id;
  explanation.grasp = grasp;
  explanation.view = seen.fovea.left;
  explanation.contour = seen.contour;
  explanation.descriptor = model.descriptor;
  explanation.patch = explain_patch(seen.contour, patches.centres_px[static_cast<std::size_t>(grasp.patch)],
                                    patches.features.row(grasp.patch), model, options);
  if (std::abs(explanation.patch.probability - grasp.probability_left) > 1e-9) {
    throw InvalidInput("model '" + model.name + "': expected the one that the grasp was found with");
  }
  return explanation;
}

PatchExplanation find_training_patches(const PatchExplanation& explanation, const GraspModel& model,
                                       const std::vector<LabelledView>& views) {
  PatchExplanation found = explanation;
  for (std::vector<NearImage>* images : {&found.graspable, &found.not_graspable}) {
    for (NearImage& image : *images) image.patch = nearest_patch(image, model, views);
  }
  return found;
}

}  // namespace graspctx
