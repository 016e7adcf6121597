#include <gtest/gtest.h>

#include "graspctx/error.hpp"
#include "graspctx/grasp_points.hpp"

namespace graspctx {
namespace {

/// A full grid of patches, row by row.
PatchDescriptors grid(int width, int height) {
  PatchDescriptors patches;
  patches.grid = {width, height};
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      patches.cells.emplace_back(column, row);
      patches.centres_px.emplace_back(column * 10 + 4.5f, row * 10 + 4.5f);
    }
  }
  return patches;
}

TEST(GraspPoints, FindsLocalMaximaHighestFirst) {
  const PatchDescriptors patches = grid(9, 7);
  Eigen::VectorXd response = Eigen::VectorXd::Constant(63, 0.1);
  const auto bump = [&](int column, int row, double height) {
    for (int r = -1; r <= 1; ++r) {
      for (int c = -1; c <= 1; ++c) response[(row + r) * 9 + column + c] = 0.8 * height;
    }
    response[row * 9 + column] = height;
  };
  bump(2, 2, 0.7);
  bump(6, 4, 0.9);
  GraspPointOptions options;
  options.max_points = 2;
  const auto points = find_grasp_points(patches, response, options);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].patch, 4 * 9 + 6);
  EXPECT_EQ(points[1].patch, 2 * 9 + 2);
  EXPECT_EQ(points[0].probability, 0.9);
  EXPECT_EQ(points[0].centre_px, cv::Point2f(64.5f, 44.5f));
}

TEST(GraspPoints, ALonePeakIsNoise) {
  const PatchDescriptors patches = grid(5, 5);
  Eigen::VectorXd response = Eigen::VectorXd::Constant(25, 0.01);
  response[12] = 0.9;
  for (const GraspPoint& point : find_grasp_points(patches, response)) EXPECT_NE(point.patch, 12);
}

TEST(GraspPoints, APlateauIsOnePoint) {
  const PatchDescriptors patches = grid(6, 6);
  const auto points = find_grasp_points(patches, Eigen::VectorXd::Constant(36, 0.5));
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].patch, 0);
}

TEST(GraspPoints, KeepsAtMostAsManyAsAsked) {
  const PatchDescriptors patches = grid(40, 40);
  Eigen::VectorXd response(1600);
  for (int i = 0; i < 1600; ++i)
    response[i] = 0.6 + ((i % 40) % 2 == 0 && (i / 40) % 2 == 0 ? 0.1 + 1e-5 * i : 0.0);
  EXPECT_EQ(find_grasp_points(patches, response).size(), 10u);
  GraspPointOptions options;
  options.max_points = 3;
  const auto points = find_grasp_points(patches, response, options);
  ASSERT_EQ(points.size(), 3u);
  EXPECT_GE(points[0].probability, points[1].probability);
  EXPECT_GE(points[1].probability, points[2].probability);
}

TEST(GraspPoints, RefusesBadInput) {
  EXPECT_THROW(find_grasp_points(grid(3, 3), Eigen::VectorXd::Zero(8)), InvalidInput);
  GraspPointOptions options;
  options.max_points = 0;
  EXPECT_THROW(find_grasp_points(grid(3, 3), Eigen::VectorXd::Zero(9), options), InvalidInput);
  EXPECT_TRUE(find_grasp_points({}, Eigen::VectorXd()).empty());
}

}  // namespace
}  // namespace graspctx
