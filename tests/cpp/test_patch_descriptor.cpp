#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "graspctx/error.hpp"
#include "graspctx/patch_descriptor.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

Contour mug_contour(const cv::Size& size = {640, 480}, const cv::Point& at = {260, 200}) {
  const auto mug = testing::draw_mug(size, at);
  return sample_contour(mug.image, mug.mask);
}

/// Every window summed from scratch over all samples.
Eigen::RowVectorXf brute_force(const Contour& contour, const cv::Point& cell,
                               const ShapeContextOptions& options = {}) {
  const FeatureMatrix contexts = shape_contexts(contour.points, options, {}, contour.border_px);
  const int bins = options.bins();
  Eigen::RowVectorXf feature = Eigen::RowVectorXf::Zero(3 * bins);
  for (int scale = 0; scale < 3; ++scale) {
    const int reach = std::array<int, 3>{0, 1, 3}[static_cast<std::size_t>(scale)];
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(bins);
    for (std::size_t i = 0; i < contour.points.size(); ++i) {
      const int column = static_cast<int>(contour.points[i].x) / 10,
                row = static_cast<int>(contour.points[i].y) / 10;
      if (std::abs(column - cell.x) <= reach && std::abs(row - cell.y) <= reach) {
        sum += contexts.row(static_cast<Eigen::Index>(i)).cast<double>();
      }
    }
    if (sum.sum() > 0) feature.segment(scale * bins, bins) = (sum / sum.sum()).cwiseSqrt().cast<float>();
  }
  return feature;
}

TEST(PatchDescriptor, EqualsBruteForce) {
  const Contour contour = mug_contour();
  const PatchDescriptors patches = patch_descriptors(contour, {640, 480});
  ASSERT_GT(patches.cells.size(), 50u);
  EXPECT_EQ(patches.features.cols(), 120);
  EXPECT_EQ(patches.grid, cv::Size(64, 48));
  for (std::size_t m = 0; m < patches.cells.size(); ++m) {
    const auto row = static_cast<Eigen::Index>(m);
    EXPECT_LT((patches.features.row(row) - brute_force(contour, patches.cells[m])).cwiseAbs().maxCoeff(),
              1e-6);
    EXPECT_EQ(patches.centres_px[m].x, static_cast<float>(patches.cells[m].x * 10 + 4.5));
  }
}

TEST(PatchDescriptor, WithTheOutlineEqualsBruteForce) {
  const Contour contour = mug_contour();
  DescriptorOptions twice;
  twice.shape_context.outline_px = 3;
  EXPECT_EQ(twice.dimension(), 240);
  const PatchDescriptors patches = patch_descriptors(contour, {640, 480}, twice);
  const FeatureMatrix contexts = shape_contexts(contour.points, twice.shape_context, {}, contour.border_px);
  ASSERT_EQ(patches.features.cols(), 240);
  ASSERT_EQ(patches.cells, patch_descriptors(contour, {640, 480}).cells);
  for (std::size_t m = 0; m < patches.cells.size(); ++m) {
    const Eigen::RowVectorXf row = patches.features.row(static_cast<Eigen::Index>(m));
    const Eigen::RowVectorXf expected = brute_force(contour, patches.cells[m], twice.shape_context);
    EXPECT_LT((row - expected).cwiseAbs().maxCoeff(), 1e-6);
    const auto alone = patch_descriptor_at(contour, contexts, patches.centres_px[m], twice);
    ASSERT_TRUE(alone);
    EXPECT_LT((*alone - row).cwiseAbs().maxCoeff(), 1e-6);
  }
  EXPECT_THROW(patch_descriptors({contour.points, contour.gradients_rad, {}}, {640, 480}, twice),
               InvalidInput);
}

TEST(PatchDescriptor, EachScaleHasUnitNorm) {
  const PatchDescriptors patches = patch_descriptors(mug_contour(), {640, 480});
  for (Eigen::Index m = 0; m < patches.features.rows(); ++m) {
    for (int scale = 0; scale < 3; ++scale)
      EXPECT_NEAR(patches.features.row(m).segment(scale * 40, 40).norm(), 1, 1e-5);
  }
}

TEST(PatchDescriptor, OnlyPatchesWithSamplesAreDescribed) {
  const Contour contour = mug_contour();
  const PatchDescriptors patches = patch_descriptors(contour, {640, 480});
  std::vector<bool> holds(64 * 48, false);
  for (const cv::Point2f& p : contour.points)
    holds[static_cast<std::size_t>(int(p.y) / 10 * 64 + int(p.x) / 10)] = true;
  for (const cv::Point& cell : patches.cells)
    EXPECT_TRUE(holds[static_cast<std::size_t>(cell.y * 64 + cell.x)]);
  EXPECT_EQ(static_cast<std::size_t>(std::count(holds.begin(), holds.end(), true)), patches.cells.size());
}

TEST(PatchDescriptor, AtAGridCentreEqualsTheGrid) {
  const Contour contour = mug_contour();
  const PatchDescriptors patches = patch_descriptors(contour, {640, 480});
  const FeatureMatrix contexts = shape_contexts(contour.points);
  for (std::size_t m = 0; m < patches.cells.size(); ++m) {
    const auto feature = patch_descriptor_at(contour, contexts, patches.centres_px[m]);
    ASSERT_TRUE(feature);
    EXPECT_LT((*feature - patches.features.row(static_cast<Eigen::Index>(m))).cwiseAbs().maxCoeff(), 1e-6);
  }
  EXPECT_FALSE(patch_descriptor_at(contour, contexts, {5, 5}));
  EXPECT_THROW(patch_descriptor_at(contour, contexts.leftCols(30), {5, 5}), InvalidInput);
}

TEST(PatchDescriptor, APatchIsHalfOpenAsInTheGrid) {
  Contour contour;
  contour.points = {{10, 4}, {12, 30}, {40, 9}};  // the first lies 5 px right of the centre at (5, 4)
  const FeatureMatrix contexts = shape_contexts(contour.points);
  EXPECT_FALSE(patch_descriptor_at(contour, contexts, {5, 4}));
  const auto feature = patch_descriptor_at(contour, contexts, {15, 4});
  ASSERT_TRUE(feature);
  EXPECT_NEAR(feature->head(40).norm(), 1, 1e-6);
}

TEST(PatchDescriptor, AShiftByAWholePatchShiftsTheDescriptors) {
  const PatchDescriptors here = patch_descriptors(mug_contour({640, 480}, {260, 200}), {640, 480});
  const PatchDescriptors there = patch_descriptors(mug_contour({640, 480}, {280, 230}), {640, 480});
  ASSERT_EQ(here.cells.size(), there.cells.size());
  for (std::size_t m = 0; m < here.cells.size(); ++m)
    EXPECT_EQ(here.cells[m] + cv::Point(2, 3), there.cells[m]);
  EXPECT_EQ((here.features - there.features).cwiseAbs().maxCoeff(), 0);
}

TEST(PatchDescriptor, TheFoveaMakesDistanceMeanNothing) {
  // The same object at twice the size: patches of the foveal view carry almost the same numbers.
  const auto near = testing::draw_mug({640, 480}, {260, 200}, 80),
             far = testing::draw_mug({640, 480}, {260, 200}, 40);
  const PatchDescriptors near_patches = describe_view(foveal_view(near.image, near.mask));
  const PatchDescriptors far_patches = describe_view(foveal_view(far.image, far.mask));
  int compared = 0;
  double distance = 0;
  for (std::size_t i = 0; i < near_patches.cells.size(); ++i) {
    for (std::size_t j = 0; j < far_patches.cells.size(); ++j) {
      if (near_patches.cells[i] != far_patches.cells[j]) continue;
      distance += (near_patches.features.row(static_cast<Eigen::Index>(i)) -
                   far_patches.features.row(static_cast<Eigen::Index>(j)))
                      .norm();
      ++compared;
    }
  }
  ASSERT_GT(compared, 40);
  EXPECT_LT(distance / compared, 0.5);  // three unit vectors: unrelated ones differ by 1.5 and more
}

TEST(PatchDescriptor, RefusesBadInput) {
  const Contour contour = mug_contour();
  EXPECT_THROW(patch_descriptors(contour, {0, 10}), InvalidInput);
  constexpr int huge = std::numeric_limits<int>::max();
  EXPECT_THROW(patch_descriptors(contour, {huge, huge}), InvalidInput);
  EXPECT_THROW(patch_descriptors(contour, {100, 100}), InvalidInput);  // points outside
  DescriptorOptions options;
  options.patch.windows_patches = {1, 2, 7};
  EXPECT_THROW(patch_descriptors(contour, {640, 480}, options), InvalidInput);
  EXPECT_EQ(patch_descriptors({}, {640, 480}).features.rows(), 0);
}

}  // namespace
}  // namespace graspctx
