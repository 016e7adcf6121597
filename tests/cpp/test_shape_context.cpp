#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "graspctx/error.hpp"
#include "graspctx/shape_context.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::uniform;

std::vector<cv::Point2f> random_contour(std::mt19937& generator, int count, bool integer) {
  // A wobbling closed curve, as outlines are, with some points strewn inside it.
  std::vector<cv::Point2f> points;
  const double radius = uniform(generator, 20, 120), wobble = uniform(generator, 0, 0.5);
  const int lobes = 1 + static_cast<int>(generator() % 6);
  for (int i = 0; i < count; ++i) {
    const double t = 6.283185307179586 * (i + 0.137) / count;  // no two points exactly side by side
    const double r = radius * (1 + wobble * std::cos(lobes * t)) * (generator() % 4 ? 1 : uniform(generator));
    const double u = 150 + r * std::cos(t), v = 150 + r * std::sin(t);
    points.emplace_back(static_cast<float>(integer ? std::round(u) : u),
                        static_cast<float>(integer ? std::round(v) : v));
  }
  return points;
}

/// Belongie et al. written from their definition, without an angle or a logarithm: the octant by comparing
/// coordinates exactly, the ring by comparing with 1/8, 1/4, 1/2, 1 and 2 mean distances.
FeatureMatrix reference_8x5(const std::vector<cv::Point2f>& points) {
  const std::size_t n = points.size();
  double total = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      const double x = double(points[j].x) - points[i].x, y = double(points[j].y) - points[i].y;
      total += std::sqrt(x * x + y * y);
    }
  }
  const double mean = total / (n * (n - 1) / 2.0);
  FeatureMatrix counts = FeatureMatrix::Zero(n, 40);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      if (i == j) continue;
      const double x = double(points[j].x) - points[i].x, y = double(points[j].y) - points[i].y;
      int octant = 0;
      if (y >= 0 && x > 0)
        octant = y < x ? 0 : 1;
      else if (y > 0 && x <= 0)
        octant = -x < y ? 2 : 3;
      else if (y <= 0 && x < 0)
        octant = -y < -x ? 4 : 5;
      else if (y < 0 && x >= 0)
        octant = x < -y ? 6 : 7;
      const double r = std::sqrt(x * x + y * y) / mean;
      const std::array<double, 5> edges{0.125, 0.25, 0.5, 1, 2};
      for (std::size_t ring = 0; ring < 5; ++ring) {
        if (r < edges[ring]) {
          counts(i, octant * 5 + ring) += 1;
          break;
        }
      }
    }
  }
  return counts;
}

TEST(ShapeContext, CountsEqualTheReferenceOnAThousandRandomContours) {
  std::mt19937 generator(20260101);
  int differences = 0;
  for (int contour = 0; contour < 1000; ++contour) {
    const auto points = random_contour(generator, 2 + static_cast<int>(generator() % 150), contour % 2 == 0);
    if ((shape_contexts(points) - reference_8x5(points)).cwiseAbs().maxCoeff() != 0) ++differences;
  }
  EXPECT_EQ(differences, 0);
}

TEST(ShapeContext, OctantBordersBelongToTheBinTheyOpen) {
  // Eight neighbours at multiples of 45°: one in each octant.
  std::vector<cv::Point2f> points{{0, 0}};
  for (const auto& [u, v] : std::vector<std::array<int, 2>>{
           {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) {
    points.emplace_back(static_cast<float>(10 * u), static_cast<float>(10 * v));
  }
  const FeatureMatrix counts = shape_contexts(points);
  for (int octant = 0; octant < 8; ++octant)
    EXPECT_EQ(counts.row(0).segment(octant * 5, 5).sum(), 1) << octant;
}

TEST(ShapeContext, AMirroredContourMirrorsTheHistogram) {
  std::mt19937 generator(3);
  const auto points = random_contour(generator, 120, false);
  auto mirrored = points;
  for (cv::Point2f& p : mirrored) p.y = -p.y;
  const FeatureMatrix counts = shape_contexts(points), mirror = shape_contexts(mirrored);
  FeatureMatrix expected(counts.rows(), counts.cols());
  for (int octant = 0; octant < 8; ++octant) {
    expected.middleCols(octant * 5, 5) = counts.middleCols((7 - octant) * 5, 5);
  }
  EXPECT_EQ((mirror - expected).cwiseAbs().maxCoeff(), 0);
}

TEST(ShapeContext, DoesNotSeeShiftOrScale) {
  std::mt19937 generator(4);
  const auto points = random_contour(generator, 100, true);
  auto moved = points;
  for (cv::Point2f& p : moved) p = 2 * p + cv::Point2f(64, -32);  // exact in floating point
  EXPECT_EQ((shape_contexts(points) - shape_contexts(moved)).cwiseAbs().maxCoeff(), 0);
}

TEST(ShapeContext, RelativeAnglesTurnWithTheGradient) {
  std::mt19937 generator(5);
  const auto points = random_contour(generator, 80, false);
  std::vector<float> gradients(points.size(), 0);
  ShapeContextOptions relative;
  relative.relative_to_gradient = true;
  EXPECT_EQ((shape_contexts(points, relative, gradients) - shape_contexts(points)).cwiseAbs().maxCoeff(), 0);
  // Turned by a quarter: what lay in octant k lies in octant k − 2.
  gradients.assign(points.size(), static_cast<float>(1.5707963267948966 - 1e-7));
  const FeatureMatrix counts = shape_contexts(points), turned = shape_contexts(points, relative, gradients);
  for (int octant = 0; octant < 8; ++octant) {
    EXPECT_EQ(
        (turned.middleCols(octant * 5, 5) - counts.middleCols((octant + 2) % 8 * 5, 5)).cwiseAbs().maxCoeff(),
        0);
  }
  EXPECT_THROW(shape_contexts(points, relative), InvalidInput);
}

TEST(ShapeContext, TheOutlineHasASecondHistogram) {
  std::mt19937 generator(7);
  const auto points = random_contour(generator, 60, false);
  std::vector<float> border_px;
  for (std::size_t i = 0; i < points.size(); ++i) border_px.push_back(static_cast<float>(generator() % 9));
  ShapeContextOptions twice;
  twice.outline_px = 3;
  const FeatureMatrix counts = shape_contexts(points, twice, {}, border_px);
  ASSERT_EQ(counts.cols(), 80);

  FeatureMatrix expected = FeatureMatrix::Zero(60, 80);
  const FeatureMatrix all = shape_contexts(points);
  double total = 0;
  for (const auto& p : points) {
    for (const auto& q : points) total += std::hypot(double(p.x) - q.x, double(p.y) - q.y);
  }
  const double mean = total / (60 * 59);
  for (std::size_t i = 0; i < 60; ++i) {
    for (std::size_t j = 0; j < 60; ++j) {
      const double x = double(points[j].x) - points[i].x, y = double(points[j].y) - points[i].y;
      const double radius = std::hypot(x, y) / mean;
      if (i == j || radius >= 2) continue;
      const int ring = radius < 0.125 ? 0 : 1 + static_cast<int>(std::log2(radius / 0.125));
      const int octant = static_cast<int>((std::atan2(y, x) / 6.283185307179586 + 1) * 8) % 8;
      expected(i, octant * 5 + ring) += 1;
      if (border_px[j] <= 3) expected(i, 40 + octant * 5 + ring) += 1;
    }
  }
  EXPECT_EQ((counts - expected).cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ((counts.leftCols(40) - all).cwiseAbs().maxCoeff(), 0);

  EXPECT_THROW(shape_contexts(points, twice), InvalidInput);
  border_px.back() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(shape_contexts(points, twice, {}, border_px), InvalidInput);
  twice.outline_px = -1;
  EXPECT_THROW(shape_contexts(points, twice), InvalidInput);
}

TEST(ShapeContext, EveryPairIsCountedWithinTheOuterRadius) {
  std::mt19937 generator(6);
  const auto points = random_contour(generator, 150, false);
  ShapeContextOptions wide;
  wide.outer_radius = 1e6;
  EXPECT_EQ(shape_contexts(points, wide).sum(), 150 * 149);
  EXPECT_LE(shape_contexts(points).sum(), 150 * 149);
}

TEST(ShapeContext, TakesDegenerateContours) {
  EXPECT_EQ(shape_contexts({}).rows(), 0);
  EXPECT_EQ(shape_contexts({{3, 4}}).sum(), 0);
  EXPECT_EQ(shape_contexts({{3, 4}, {3, 4}, {3, 4}}).sum(), 6);  // one place: nothing to normalise by
}

TEST(ShapeContext, RefusesBadInput) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(shape_contexts({{0, 0}, {nan, 1}}), InvalidInput);
  ShapeContextOptions options;
  options.angular_bins = 0;
  EXPECT_THROW(shape_contexts({{0, 0}, {1, 1}}, options), InvalidInput);
  options = {};
  options.outer_radius = options.inner_radius;
  EXPECT_THROW(shape_contexts({{0, 0}, {1, 1}}, options), InvalidInput);
}

}  // namespace
}  // namespace graspctx
