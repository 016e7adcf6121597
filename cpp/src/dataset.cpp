#include "graspctx/dataset.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <utility>
#include <vector>

#include "detail/check.hpp"
#include "detail/image_name.hpp"
#include "detail/quantile.hpp"

namespace graspctx {

namespace {

/// Uniform in [0, 1). The standard's distributions may differ from library to library; this may not.
double uniform(std::mt19937& generator) {
  return generator() / 4294967296.0;
}

double object_extent_px(const cv::Mat& mask) {
  const cv::Rect box = cv::boundingRect(mask);
  return std::max(box.width, box.height);
}

cv::Mat dilated(const cv::Mat& mask, double radius_px) {
  const int side = 2 * std::max(1, static_cast<int>(std::lround(radius_px))) + 1;
  cv::Mat result;
  cv::dilate(mask, result, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  return result;
}

/// The part of the pixels on the positive side of a line at the given share of the object along a direction.
cv::Mat beyond_line(const cv::Mat& mask, double direction_rad, double share) {
  std::vector<cv::Point> pixels;
  cv::findNonZero(mask, pixels);
  const double cu = std::cos(direction_rad), cv_ = std::sin(direction_rad);
  std::vector<double> along;
  along.reserve(pixels.size());
  for (const cv::Point& p : pixels) along.push_back(cu * p.x + cv_ * p.y);
  const double border = detail::quantile(std::move(along), share);
  cv::Mat side(mask.size(), CV_8UC1);
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) side.at<uchar>(v, u) = cu * u + cv_ * v >= border ? 255 : 0;
  }
  return side;
}

/// A mask as imperfect as those a segmentation gives: too large, with a wedge of the background, or cut off.
cv::Mat degrade(const cv::Mat& mask, std::mt19937& generator) {
  const double extent_px = object_extent_px(mask);
  const double kind = uniform(generator), amount = uniform(generator);
  const double direction_rad = 6.283185307179586 * uniform(generator);
  if (kind < 0.5) return dilated(mask, extent_px * (0.005 + 0.035 * amount));
  if (kind < 0.8) {
    const cv::Mat grown = dilated(mask, extent_px * (0.03 + 0.07 * amount));
    cv::Mat wedge;
    cv::bitwise_and(grown, beyond_line(mask, direction_rad, 0.5), wedge);
    cv::bitwise_or(wedge, mask, wedge);
    return wedge;
  }
  cv::Mat cut;
  cv::bitwise_and(mask, beyond_line(mask, direction_rad, 0.02 + 0.08 * amount), cut);
  return cut;
}

LabelledPatches describe_checked(const LabelledView& view, const DescriptorOptions& options) {
  const FovealView fovea = foveal_view(view.image, view.mask, options.fovea);
  const cv::Matx23d view_from_image(fovea.scale, 0, -fovea.scale * fovea.origin_px.x(), 0, fovea.scale,
                                    -fovea.scale * fovea.origin_px.y());
  cv::Mat label;
  cv::warpAffine(view.label > 0, label, view_from_image, fovea.image.size(), cv::INTER_NEAREST,
                 cv::BORDER_CONSTANT);

  LabelledPatches result;
  result.patches = describe_view(fovea, options);
  const int patch_px = options.patch.patch_px;
  for (const cv::Point& cell : result.patches.cells) {
    const cv::Rect patch =
        cv::Rect(cell.x * patch_px, cell.y * patch_px, patch_px, patch_px) & cv::Rect({0, 0}, label.size());
    const int labelled_px = cv::countNonZero(label(patch));
    result.labels.push_back(labelled_px > 0 ? 1 : 0);
    result.label_share.push_back(static_cast<float>(labelled_px) / static_cast<float>(patch.area()));
  }
  result.visible_label_share = visible_label_share(view);
  return result;
}

void check_view(const LabelledView& view) {
  const std::string where = view.source.empty() ? "labelled view" : view.source;
  detail::require_image(view.image, (where + ": image").c_str());
  detail::require_mask(view.mask, view.image.size(), (where + ": mask").c_str());
  detail::require_mask(view.label, view.image.size(), (where + ": label").c_str());
}

/// A view with its true mask, then its copies with degraded masks.
std::vector<LabelledView> augment_view(const LabelledView& view, int degraded_masks,
                                       std::mt19937& generator) {
  check_view(view);
  std::vector<LabelledView> result{view};
  const cv::Mat mask = view.mask > 0;
  for (int copy = 0; copy < degraded_masks; ++copy) {
    const cv::Mat degraded = degrade(mask, generator);
    if (cv::countNonZero(degraded) == 0) continue;
    result.push_back(view);
    result.back().mask = degraded;
  }
  return result;
}

}  // namespace

std::map<int, std::string> image_names(const std::vector<LabelledView>& views) {
  std::map<int, std::string> names;
  for (const LabelledView& view : views) {
    const bool is_name = detail::is_image_name(view.image_name);
    names[view.group] = is_name ? view.image_name : "image " + std::to_string(view.group);
  }
  return names;
}

void AugmentOptions::check() const {
  detail::require_option(degraded_masks >= 0 && degraded_masks <= 100, "degraded_masks must be 0 to 100");
}

double visible_label_share(const LabelledView& view) {
  return static_cast<double>(cv::countNonZero(view.label)) / std::max(1, cv::countNonZero(view.mask));
}

LabelledPatches describe_labelled_view(const LabelledView& view, const DescriptorOptions& options) {
  check_view(view);
  return describe_checked(view, options);
}

std::vector<LabelledView> augment_views(const std::vector<LabelledView>& views,
                                        const AugmentOptions& options) {
  options.check();
  std::vector<LabelledView> result;
  std::mt19937 generator(options.seed);
  for (const LabelledView& view : views) {
    const std::vector<LabelledView> copies = augment_view(view, options.degraded_masks, generator);
    result.insert(result.end(), copies.begin(), copies.end());
  }
  return result;
}

TrainingSet build_training_set(const std::vector<LabelledView>& views, const DescriptorOptions& descriptor,
                               const AugmentOptions& augment, const std::function<void(double)>& progress) {
  descriptor.check();
  augment.check();
  TrainingSet set;
  std::vector<FeatureMatrix> blocks;
  std::mt19937 generator(augment.seed);
  for (std::size_t i = 0; i < views.size(); ++i) {
    int index = static_cast<int>(i);
    for (const LabelledView& view : augment_view(views[i], augment.degraded_masks, generator)) {
      const LabelledPatches described = describe_checked(view, descriptor);
      set.views.insert(set.views.end(), described.labels.size(), static_cast<int>(blocks.size()));
      blocks.push_back(described.patches.features);
      set.labels.insert(set.labels.end(), described.labels.begin(), described.labels.end());
      set.groups.insert(set.groups.end(), described.labels.size(), view.group);
      set.true_views.insert(set.true_views.end(), described.labels.size(), index);
      set.label_share.insert(set.label_share.end(), described.label_share.begin(),
                             described.label_share.end());
      index = -1;  // the copies that follow have degraded masks
    }
    if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(views.size()));
  }

  set.features.resize(static_cast<Eigen::Index>(set.labels.size()), descriptor.dimension());
  Eigen::Index row = 0;
  for (const FeatureMatrix& block : blocks) {
    set.features.middleRows(row, block.rows()) = block;
    row += block.rows();
  }
  return set;
}

}  // namespace graspctx
