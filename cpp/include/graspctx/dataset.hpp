#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "graspctx/export.hpp"
#include "graspctx/patch_descriptor.hpp"

namespace graspctx {

/// One labelled view of one object.
struct LabelledView {
  std::string source;           // file or scene it comes from, for messages
  std::string class_name;       // object family
  int group = 0;                // the two views of one scene share a group; folds never part a group
  cv::Mat image;                // CV_8UC3 or CV_8UC1
  cv::Mat mask;                 // CV_8UC1, > 0 = the object
  cv::Mat label;                // CV_8UC1, > 0 = grasp region
  std::string image_name = {};  // of the image or scene, within its data set; one for each group
};

/// The name of each group's image, for TrainOptions::image_names: LabelledView::image_name, or "image N" with
/// the group's number where that is empty or may not stand in a model's file (no printable UTF-8, say).
GRASPCTX_EXPORT std::map<int, std::string> image_names(const std::vector<LabelledView>& views);

/// The patches of a labelled view. A patch is positive if it overlaps the labelled region (III-C).
struct LabelledPatches {
  PatchDescriptors patches;
  std::vector<int> labels;         // (M) 0 or 1
  std::vector<float> label_share;  // (M) share of the patch's pixels that are labelled
  double visible_label_share = 0;  // labelled pixels over object pixels
};

/// Labelled pixels over object pixels.
GRASPCTX_EXPORT double visible_label_share(const LabelledView& view);

GRASPCTX_EXPORT LabelledPatches describe_labelled_view(const LabelledView& view,
                                                       const DescriptorOptions& options = {});

struct GRASPCTX_EXPORT AugmentOptions {
  int degraded_masks = 1;  // copies of each view with a mask as imperfect as those met later
  std::uint32_t seed = 1;
  void check() const;
};

/// The views that are trained on: each with its true mask, then its copies with masks that are too large,
/// carry a wedge of the background or are cut off (METHOD 5). Copies share image and label; a mask of which
/// nothing is left makes none. Throws InvalidInput if a view cannot be described.
GRASPCTX_EXPORT std::vector<LabelledView> augment_views(const std::vector<LabelledView>& views,
                                                        const AugmentOptions& options = {});

/// Training rows gathered over many views, in order.
struct TrainingSet {
  FeatureMatrix features;   // (R, D)
  std::vector<int> labels;  // (R)
  std::vector<int> groups;  // (R) LabelledView::group
  std::vector<int> views;   // (R) number of the view: each mask of each labelled view is one
  // What held-out rows are measured by.
  std::vector<int> true_views;  // (R) index of the labelled view that the row is of, -1 with a degraded mask
  std::vector<float> label_share;  // (R) share of the patch's pixels that are labelled
};

/// Describe every view with its true mask, and again with degraded ones: the patches of augment_views.
/// Throws InvalidInput if a view cannot be described.
GRASPCTX_EXPORT TrainingSet build_training_set(const std::vector<LabelledView>& views,
                                               const DescriptorOptions& descriptor = {},
                                               const AugmentOptions& augment = {},
                                               const std::function<void(double share)>& progress = {});

}  // namespace graspctx
