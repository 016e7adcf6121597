#include "graspctx/patch_descriptor.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "detail/check.hpp"
#include "detail/patch_window.hpp"

namespace graspctx {

void PatchOptions::check() const {
  detail::require_option(patch_px >= 2 && patch_px <= 200, "patch_px must be 2 to 200");
  for (const int window : windows_patches) {
    detail::require_option(window >= 1 && window <= 99 && window % 2 == 1,
                           "windows_patches must be odd, 1 to 99 patches");
  }
}

void DescriptorOptions::check() const {
  fovea.check();
  contour.check();
  shape_context.check();
  patch.check();
}

DescriptorOptions robust_descriptor() {
  DescriptorOptions options;
  options.fovea.refine_mask = true;
  options.shape_context.outline_px = 3;
  return options;
}

PatchDescriptors patch_descriptors(const Contour& contour, const cv::Size& image_size,
                                   const DescriptorOptions& options) {
  options.check();
  constexpr int largest_px = 32767;  // as of any image; a grid far beyond would overflow
  if (image_size.width < 1 || image_size.height < 1 || image_size.width > largest_px ||
      image_size.height > largest_px) {
    throw InvalidInput("image size: expected sides of 1 to 32767 px, got " +
                       std::to_string(image_size.width) + "x" + std::to_string(image_size.height));
  }
  const int patch_px = options.patch.patch_px;
  const int bins = options.shape_context.bins();
  const FeatureMatrix contexts =
      shape_contexts(contour.points, options.shape_context, contour.gradients_rad, contour.border_px);

  PatchDescriptors patches;
  patches.grid = {(image_size.width + patch_px - 1) / patch_px,
                  (image_size.height + patch_px - 1) / patch_px};
  const auto cell_index = [&](int column, int row) { return row * patches.grid.width + column; };

  // The histograms of the samples in each patch, summed.
  FeatureMatrix cell_sums = FeatureMatrix::Zero(patches.grid.area(), bins);
  std::vector<bool> occupied(static_cast<std::size_t>(patches.grid.area()), false);
  for (std::size_t i = 0; i < contour.points.size(); ++i) {
    const cv::Point2f& p = contour.points[i];
    if (!(p.x > -0.5f && p.y > -0.5f && p.x < static_cast<float>(image_size.width) &&
          p.y < static_cast<float>(image_size.height))) {
      throw InvalidInput("contour: a point lies outside the image of " + std::to_string(image_size.width) +
                         "x" + std::to_string(image_size.height));
    }
    // Pixel centres are at integers: the first patch covers [−0.5, patch_px − 0.5).
    const int column =
        std::min(static_cast<int>((p.x + 0.5f) / static_cast<float>(patch_px)), patches.grid.width - 1);
    const int row =
        std::min(static_cast<int>((p.y + 0.5f) / static_cast<float>(patch_px)), patches.grid.height - 1);
    cell_sums.row(cell_index(column, row)) += contexts.row(static_cast<Eigen::Index>(i));
    occupied[static_cast<std::size_t>(cell_index(column, row))] = true;
  }

  const auto count = static_cast<Eigen::Index>(std::count(occupied.begin(), occupied.end(), true));
  patches.features = FeatureMatrix::Zero(count, options.dimension());
  for (int row = 0; row < patches.grid.height; ++row) {
    for (int column = 0; column < patches.grid.width; ++column) {
      if (!occupied[static_cast<std::size_t>(cell_index(column, row))]) continue;
      const auto m = static_cast<Eigen::Index>(patches.cells.size());
      patches.cells.emplace_back(column, row);
      patches.centres_px.emplace_back(static_cast<float>((column + 0.5) * patch_px - 0.5),
                                      static_cast<float>((row + 0.5) * patch_px - 0.5));
      for (int scale = 0; scale < 3; ++scale) {
        const int reach = options.patch.windows_patches[static_cast<std::size_t>(scale)] / 2;
        auto window = patches.features.row(m).segment(scale * bins, bins);
        for (int r = std::max(0, row - reach); r <= std::min(patches.grid.height - 1, row + reach); ++r) {
          for (int c = std::max(0, column - reach); c <= std::min(patches.grid.width - 1, column + reach);
               ++c) {
            window += cell_sums.row(cell_index(c, r));
          }
        }
        detail::normalise(window);
      }
    }
  }
  return patches;
}

std::optional<Eigen::RowVectorXf> patch_descriptor_at(const Contour& contour, const FeatureMatrix& contexts,
                                                      const cv::Point2f& centre_px,
                                                      const DescriptorOptions& options) {
  options.check();
  const int bins = options.shape_context.bins();
  if (contexts.rows() != static_cast<Eigen::Index>(contour.points.size()) || contexts.cols() != bins) {
    throw InvalidInput("patch descriptor: expected shape contexts of (" +
                       std::to_string(contour.points.size()) + ", " + std::to_string(bins) + "), got (" +
                       std::to_string(contexts.rows()) + ", " + std::to_string(contexts.cols()) + ")");
  }
  const int patch_px = options.patch.patch_px;
  Eigen::RowVectorXf feature = Eigen::RowVectorXf::Zero(options.dimension());
  bool occupied = false;
  for (std::size_t i = 0; i < contour.points.size(); ++i) {
    const cv::Point2f offset_px = contour.points[i] - centre_px;
    occupied = occupied || detail::is_in_window(offset_px, patch_px);
    for (int scale = 0; scale < 3; ++scale) {
      const int side_px = options.patch.windows_patches[static_cast<std::size_t>(scale)] * patch_px;
      if (detail::is_in_window(offset_px, side_px)) {
        feature.segment(scale * bins, bins) += contexts.row(static_cast<Eigen::Index>(i));
      }
    }
  }
  if (!occupied) return std::nullopt;
  for (int scale = 0; scale < 3; ++scale) detail::normalise(feature.segment(scale * bins, bins));
  return feature;
}

PatchDescriptors describe_view(const FovealView& view, const DescriptorOptions& options) {
  const Contour contour = sample_contour(view.image, view.mask, options.contour);
  return patch_descriptors(contour, view.image.size(), options);
}

}  // namespace graspctx
