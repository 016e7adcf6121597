#pragma once
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "graspctx/contour.hpp"
#include "graspctx/export.hpp"
#include "graspctx/fovea.hpp"
#include "graspctx/shape_context.hpp"

namespace graspctx {

struct GRASPCTX_EXPORT PatchOptions {
  int patch_px = 10;
  std::array<int, 3> windows_patches{1, 3, 7};  // width of the windows of the three scales, odd
  void check() const;
};

/// Everything the features of a patch depend on. A model carries the options it was trained with.
struct GRASPCTX_EXPORT DescriptorOptions {
  FoveaOptions fovea;
  ContourOptions contour;
  ShapeContextOptions shape_context;
  PatchOptions patch;
  int dimension() const { return 3 * shape_context.bins(); }  // 120 by default, 240 with outline_px
  void check() const;
};

/// What is trained by default: the descriptor of the paper, which the defaults of the options are, made
/// robust. The mask is refined by colour, and the outline is counted a second time (docs/recipe.md).
GRASPCTX_EXPORT DescriptorOptions robust_descriptor();

/// Descriptors of the patches of one view that hold contour samples (III-B).
struct PatchDescriptors {
  std::vector<cv::Point2f> centres_px;  // (M) of the view
  std::vector<cv::Point> cells;         // (M) column and row in the patch grid
  cv::Size grid;                        // number of columns and rows
  FeatureMatrix features;               // (M, 120)
};

/// One descriptor for each 10×10 patch that holds contour samples: the summed shape contexts of all samples
/// in a window, at three scales centred at the patch, each L1-normalised and square-rooted, concatenated
/// (III-B). The grid starts at the image's (0, 0).
GRASPCTX_EXPORT PatchDescriptors patch_descriptors(const Contour& contour, const cv::Size& image_size,
                                                   const DescriptorOptions& options = {});

/// The same descriptor at one arbitrary patch centre (a stereo match lies on no grid). Nothing if the patch
/// holds no sample. `contexts` are shape_contexts of the contour's points.
GRASPCTX_EXPORT std::optional<Eigen::RowVectorXf> patch_descriptor_at(const Contour& contour,
                                                                      const FeatureMatrix& contexts,
                                                                      const cv::Point2f& centre_px,
                                                                      const DescriptorOptions& options = {});

/// Contour, shape contexts and patch descriptors of a foveal view.
GRASPCTX_EXPORT PatchDescriptors describe_view(const FovealView& view, const DescriptorOptions& options = {});

}  // namespace graspctx
