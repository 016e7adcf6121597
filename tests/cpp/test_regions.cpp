#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "blank_cues.hpp"
#include "detail/region_features.hpp"
#include "detail/regions.hpp"
#include "same_regions.hpp"

namespace graspctx {
namespace {

using detail::Border;
using detail::Features;
using detail::Region;
using detail::region_graph;
using detail::RegionGraph;
using detail::SceneCues;
using detail::Superpixels;
using testing::blank_cues;
using testing::box_and_rest;
using testing::random_cues;
using testing::tiles;

const cv::Size image_size(60, 40);
const cv::Rect box(20, 10, 30, 16);

// Where features stand; the trees rely on it.
namespace of_object {
constexpr std::size_t at_border = 1, fill = 2, elongation = 3, extent_m = 6, off_own_plane_px = 7,
                      heights_m = 8, ground_share = 11, border_step_px = 15, guessed = 20, raised = 23;
}
namespace of_union {
constexpr std::size_t log_large = 0, log_small = 1, shared_of_small = 3, shared_of_large = 4, alike = 10,
                      step_px = 15, off_own_planes_px = 29, extents_m = 33, apart_m = 37, heights_m = 40,
                      raised = 47, same_guess = 55, same_raised = 56, in_raised_pieces = 57;
}
namespace of_foreground {
constexpr std::size_t in_raised_piece = 5, known = 6, raised = 7, on_plane = 9, raised_around = 27,
                      colour_step_around = 38, weakest_colour_step = 39, raised_piece_around = 40;
}

Features features_of_box(const SceneCues& cues, const cv::Rect& in = box) {
  const RegionGraph graph = region_graph(cues, box_and_rest(cues.image.size(), in));
  return detail::object_features(graph, 1);
}

int not_numbers(const Features& features) {
  return static_cast<int>(
      std::count_if(features.begin(), features.end(), [](float f) { return std::isnan(f); }));
}

TEST(Regions, SumsOfAKnownBox) {
  const RegionGraph graph = region_graph(blank_cues(image_size), box_and_rest(image_size, box));
  ASSERT_EQ(graph.regions.size(), 2u);
  const Region &inner = graph.regions[1], &rest = graph.regions[0];
  EXPECT_EQ(inner.sums.area, box.area());
  EXPECT_EQ(rest.sums.area, image_size.area() - box.area());
  EXPECT_EQ(inner.sums.at_border, 0);
  EXPECT_EQ(rest.sums.at_border, 2 * image_size.width + 2 * image_size.height - 4);
  EXPECT_EQ(inner.sums.u / inner.sums.area, box.x + (box.width - 1) / 2.0);
  EXPECT_EQ(inner.sums.v / inner.sums.area, box.y + (box.height - 1) / 2.0);
  EXPECT_EQ(inner.perimeter_px, 2 * (box.width + box.height));
  EXPECT_EQ(rest.perimeter_px, inner.perimeter_px);  // the image's sides are none
  EXPECT_EQ(graph.borders[0].at(1).length_px, inner.perimeter_px);
  testing::expect_same(graph.borders[0].at(1), graph.borders[1].at(0));
  EXPECT_EQ(*std::max_element(inner.colours.begin(), inner.colours.end()), box.area());  // one colour
  EXPECT_EQ(inner.sums.known, 0);
  EXPECT_EQ(inner.sums.deep, 0);
  EXPECT_EQ(inner.sums.table_misfit, -box.area());
}

TEST(Regions, CountWhatIsOverThePlane) {
  SceneCues cues = blank_cues(image_size);
  const auto put = [&](int row, float residual_px, float sigma_px) {
    cues.residual_px(cv::Rect(box.x, box.y + row, box.width, 1)).setTo(residual_px);
    cues.sigma_px(cv::Rect(box.x, box.y + row, box.width, 1)).setTo(sigma_px);
  };
  put(0, 1, 0.1F);      // raised
  put(1, 1, 0.4F);      // perhaps: 2.5 sigmas
  put(2, 0.2F, 0.02F);  // perhaps, and on the plane
  put(3, 0, 0.1F);      // on it
  put(4, -2, 0.1F);     // below
  const Region region = region_graph(cues, box_and_rest(image_size, box)).regions[1];
  EXPECT_EQ(region.sums.known, 5 * box.width);
  EXPECT_EQ(region.sums.raised, box.width);
  EXPECT_EQ(region.sums.perhaps_raised, 3 * box.width);
  EXPECT_EQ(region.sums.on_plane, 2 * box.width);
  EXPECT_EQ(region.sums.below_plane, box.width);
  EXPECT_NEAR(region.sums.residual_px, 0.2 * box.width, 1e-4);
}

TEST(Regions, AddGivesWhatTheJoinedRegionHas) {
  const SceneCues cues = random_cues(image_size, 3);
  Superpixels superpixels = tiles(image_size, {17, 13});
  const RegionGraph apart = region_graph(cues, superpixels);
  for (const auto& [a, b] : {std::pair(0, 1), std::pair(5, 9), std::pair(2, 11)}) {  // neighbours or not
    Region sum = apart.regions[std::size_t(a)];
    sum.add(apart.regions[std::size_t(b)]);
    Superpixels joined{superpixels.labels.clone(), superpixels.count};
    joined.labels.setTo(a, joined.labels == b);
    testing::expect_same_sums(sum, region_graph(cues, joined).regions[std::size_t(a)]);
  }
}

TEST(Regions, TogetherHoldEveryPixelOnce) {
  const SceneCues cues = random_cues(image_size, 4);
  const Superpixels many = tiles(image_size, {9, 7});
  const RegionGraph graph = region_graph(cues, many);
  Region sum;
  for (const Region& region : graph.regions) sum.add(region);
  const Superpixels one{cv::Mat::zeros(image_size, CV_32SC1), 1};
  testing::expect_same_sums(sum, region_graph(cues, one).regions[0]);
  EXPECT_EQ(sum.sums.area, image_size.area());
  for (std::size_t a = 0; a < graph.regions.size(); ++a) {
    double perimeter_px = 0;
    for (const auto& [b, border] : graph.borders[a]) {
      perimeter_px += border.length_px;
      testing::expect_same(border, graph.borders[std::size_t(b)].at(static_cast<int>(a)));
      double steps = 0;
      for (const double count : border.colour_steps) steps += count;
      EXPECT_EQ(steps, border.length_px);
      EXPECT_LE(border.large_steps, border.known);
      EXPECT_LE(border.dense_known, border.length_px);
    }
    EXPECT_EQ(perimeter_px, graph.regions[a].perimeter_px);
  }
}

TEST(Regions, BordersShowStepsOfColourAndDepth) {
  cv::Mat image(image_size, CV_8UC3, cv::Scalar(90, 120, 40));
  image(cv::Rect(30, 0, 30, 40)).setTo(cv::Scalar(90, 120, 140));
  SceneCues cues = blank_cues(image);
  cues.residual_px(cv::Rect(0, 0, 30, 20)).setTo(0);
  cues.residual_px(cv::Rect(30, 0, 30, 20)).setTo(2);
  cues.disparity_px(cv::Rect(0, 0, 30, 10)).setTo(50);
  cues.disparity_px(cv::Rect(30, 0, 30, 10)).setTo(50.5F);
  const Border border = region_graph(cues, tiles(image_size, {30, 40})).borders[0].at(1);
  EXPECT_EQ(border.length_px, 40);
  EXPECT_NEAR(border.colour_step / border.length_px, 87,
              3);  // 1.5 px beyond it, smoothed by 1 px: 2 erf(1.06)
  EXPECT_EQ(border.colour_steps.back(), 40);
  EXPECT_EQ(border.known, 20);
  EXPECT_EQ(border.step_px, 40);
  EXPECT_EQ(border.large_steps, 20);
  EXPECT_EQ(border.dense_known, 10);
  EXPECT_EQ(border.dense_step_px, 5);
  EXPECT_EQ(border.dense_large_steps, 0);
}

TEST(RegionFeatures, AreAsManyWhateverIsKnown) {
  const SceneCues all = random_cues(image_size, 5), nothing = blank_cues(image_size);
  const Superpixels superpixels = tiles(image_size, {20, 20});
  const RegionGraph a = region_graph(all, superpixels), b = region_graph(nothing, superpixels);
  const Features foreground_a = detail::foreground_features(a, 1, all);
  const Features foreground_b = detail::foreground_features(b, 1, nothing);
  const Features union_a = detail::union_features(a.regions[0], a.regions[1], a.borders[0].at(1));
  const Features union_b = detail::union_features(b.regions[0], b.regions[1], b.borders[0].at(1));
  const Features object_a = detail::object_features(a, 1);
  const Features object_b = detail::object_features(b, 1);
  EXPECT_EQ(foreground_a.size(), foreground_b.size());
  EXPECT_EQ(union_a.size(), union_b.size());
  EXPECT_EQ(object_a.size(), object_b.size());
  for (const Features& features : {foreground_a, union_a, object_a}) EXPECT_EQ(not_numbers(features), 0);
}

TEST(RegionFeatures, AreNotANumberWhereNothingIsKnown) {
  const SceneCues cues = blank_cues(image_size);
  const RegionGraph graph = region_graph(cues, tiles(image_size, {20, 20}));
  const Features foreground = detail::foreground_features(graph, 1, cues);
  EXPECT_EQ(foreground[of_foreground::known], 0);
  EXPECT_TRUE(std::isnan(foreground[of_foreground::raised]));
  EXPECT_TRUE(std::isnan(foreground[of_foreground::on_plane]));
  EXPECT_TRUE(std::isnan(foreground[of_foreground::raised_around]));
  EXPECT_EQ(foreground[of_foreground::colour_step_around], 0);
  const Features both = detail::union_features(graph.regions[0], graph.regions[1], graph.borders[0].at(1));
  for (const std::size_t first : {of_union::off_own_planes_px, of_union::extents_m, of_union::raised}) {
    for (std::size_t i = first; i < first + 4; ++i) EXPECT_TRUE(std::isnan(both[i])) << i;
  }
  for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(std::isnan(both[of_union::heights_m + i])) << i;
  EXPECT_TRUE(std::isnan(both[of_union::step_px]));
  EXPECT_TRUE(std::isnan(both[of_union::apart_m]));
  EXPECT_FLOAT_EQ(both[of_union::alike], 1);
  const Features object = detail::object_features(graph, 1);
  for (const std::size_t i : {of_object::extent_m, of_object::off_own_plane_px, of_object::heights_m,
                              of_object::heights_m + 2, of_object::border_step_px}) {
    EXPECT_TRUE(std::isnan(object[i])) << i;
  }
}

TEST(RegionFeatures, OfAUnionDoNotDependOnTheOrder) {
  const SceneCues cues = random_cues(image_size, 6);
  const RegionGraph graph = region_graph(cues, tiles(image_size, {17, 13}));
  for (int a = 0; a < static_cast<int>(graph.regions.size()); ++a) {
    for (const auto& [b, border] : graph.borders[std::size_t(a)]) {
      const Region &x = graph.regions[std::size_t(a)], &y = graph.regions[std::size_t(b)];
      const Features there = detail::union_features(x, y, border),
                     back = detail::union_features(y, x, border);
      ASSERT_EQ(there.size(), back.size());
      EXPECT_EQ(std::memcmp(there.data(), back.data(), there.size() * sizeof(float)), 0);  // NaN too
      EXPECT_GE(there[of_union::log_large], there[of_union::log_small]);
    }
  }
}

TEST(RegionFeatures, OfAUnionAreSharesOfBothSides) {
  // The box is cut out of the rest: all its border is shared.
  const RegionGraph graph = region_graph(random_cues(image_size, 7), box_and_rest(image_size, box));
  const Features features =
      detail::union_features(graph.regions[0], graph.regions[1], graph.borders[0].at(1));
  EXPECT_FLOAT_EQ(features[of_union::shared_of_small], 1);
  EXPECT_FLOAT_EQ(features[of_union::shared_of_large], 1);
  EXPECT_FLOAT_EQ(features[of_union::log_small], std::log(float(box.area())));
  EXPECT_FLOAT_EQ(features[of_union::log_large], std::log(float(image_size.area() - box.area())));
}

TEST(RegionFeatures, APlanarPatchLiesOnItsOwnPlane) {
  SceneCues cues = blank_cues(image_size);
  for (int v = 0; v < image_size.height; ++v) {
    for (int u = 0; u < image_size.width; ++u) {
      cues.disparity_px.at<float>(v, u) = 40 + 0.05F * float(u) - 0.03F * float(v);
      cues.point_m.at<cv::Vec3f>(v, u) = {0, 0, 1};
    }
  }
  EXPECT_LT(features_of_box(cues)[of_object::off_own_plane_px], 0.03);
  // Rows that lie 1 px nearer and farther by turns: no plane explains that.
  for (int v = 0; v < image_size.height; ++v) cues.disparity_px.row(v) += v % 2 == 0 ? 1 : -1;
  EXPECT_NEAR(features_of_box(cues)[of_object::off_own_plane_px], 1, 0.05);
}

TEST(RegionFeatures, TheExtentIsInMetres) {
  // 4 mm a pixel: 12 by 6.4 cm, however it is turned in space.
  SceneCues cues = blank_cues(image_size);
  cues.disparity_px.setTo(50);
  for (const double turn_rad : {0.0, 0.9}) {
    const Eigen::AngleAxisd turn(turn_rad, Eigen::Vector3d(1, -2, 3).normalized());
    for (int v = 0; v < image_size.height; ++v) {
      for (int u = 0; u < image_size.width; ++u) {
        const Eigen::Vector3d p =
            turn * Eigen::Vector3d(0.004 * u, 0.004 * v, 0) + Eigen::Vector3d(0, 0, 0.8);
        cues.point_m.at<cv::Vec3f>(v, u) = {float(p.x()), float(p.y()), float(p.z())};
      }
    }
    const double sigma_m = 0.004 * std::sqrt((box.width * box.width - 1) / 12.0);
    EXPECT_NEAR(features_of_box(cues)[of_object::extent_m], sigma_m, 1e-5);
  }
}

TEST(RegionFeatures, HeightsOfAWedge) {
  SceneCues cues = blank_cues(image_size);
  for (int i = 0; i < box.width; ++i) {  // evenly from 0 to 12 cm
    cues.height_m(cv::Rect(box.x + i, box.y, 1, box.height))
        .setTo(0.12F * (float(i) + 0.5F) / float(box.width));
  }
  cues.dense_height_m.setTo(0.3F);  // known worse: not asked where the other is known
  const Features features = features_of_box(cues);
  const double truth_m[] = {0.05 * 0.12, 0.5 * 0.12, 0.95 * 0.12};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(features[of_object::heights_m + i], truth_m[i], 0.011) << i;  // in classes of 1 cm
  }
  cues.height_m.setTo(std::numeric_limits<float>::quiet_NaN());
  EXPECT_NEAR(features_of_box(cues)[of_object::heights_m], 0.29, 0.011);  // the last class: 29 cm and more
  cues.dense_height_m.setTo(-7e12F);
  EXPECT_NEAR(features_of_box(cues)[of_object::heights_m], -0.02, 1e-6);
  cues.dense_height_m.setTo(7e12F);
  EXPECT_NEAR(features_of_box(cues)[of_object::heights_m], 0.29, 1e-6);
}

TEST(RegionFeatures, TheEllipseOfABox) {
  const Features features = features_of_box(blank_cues(image_size));
  EXPECT_NEAR(features[of_object::elongation], double(box.width) / box.height, 1e-3);
  EXPECT_NEAR(features[of_object::fill], 12 / (4 * CV_PI), 1e-3);  // of a rectangle, whatever its sides
  EXPECT_EQ(features[of_object::at_border], 0);
  EXPECT_EQ(features_of_box(blank_cues(image_size), {0, 5, 20, 20})[of_object::at_border], 1);
  // Bent, it fills less of it.
  Superpixels bent = box_and_rest(image_size, {5, 5, 30, 6});
  bent.labels(cv::Rect(5, 5, 6, 30)).setTo(1);
  const RegionGraph graph = region_graph(blank_cues(image_size), bent);
  EXPECT_LT(detail::object_features(graph, 1)[of_object::fill], 0.75);
}

TEST(RegionFeatures, PiecesThatTwoRegionsShare) {
  // Piece 1 lies over a third of the box and twice as much of the rest, piece 2 in the rest alone.
  SceneCues cues = blank_cues(image_size);
  cues.raised_piece(cv::Rect(box.x, box.y - 10, box.width, 15)).setTo(1);
  cues.raised_piece(cv::Rect(0, 30, 60, 5)).setTo(2);
  cues.guess_piece(box).setTo(3);
  const RegionGraph graph = region_graph(cues, box_and_rest(image_size, box));
  const Features both = detail::union_features(graph.regions[0], graph.regions[1], graph.borders[0].at(1));
  EXPECT_FLOAT_EQ(both[of_union::same_raised], 0.5F);  // of the rest's pieces half is piece 1
  EXPECT_TRUE(std::isnan(both[of_union::same_guess]));
  const double rest = image_size.area() - box.area();
  EXPECT_FLOAT_EQ(both[of_union::in_raised_pieces], float(600 / rest));
  EXPECT_FLOAT_EQ(both[of_union::in_raised_pieces + 1], 150.0F / float(box.area()));
  const Features object = detail::object_features(graph, 1);
  const float expected[] = {1, 1, 1, 150.0F / float(box.area()), 1, 1.0F / 3};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_FLOAT_EQ(object[of_object::guessed + i], expected[i]) << i;
  EXPECT_FLOAT_EQ(detail::foreground_features(graph, 0, cues)[of_foreground::in_raised_piece],
                  float(600 / rest));
  EXPECT_FLOAT_EQ(detail::foreground_features(graph, 0, cues)[of_foreground::raised_piece_around],
                  150.0F / float(box.area()));
}

TEST(RegionFeatures, NeighboursWeighAsMuchAsTheirBorders) {
  SceneCues cues = blank_cues(image_size);
  cues.has_plane = true;
  cues.residual_px.setTo(0);
  Superpixels superpixels{cv::Mat::zeros(image_size, CV_32SC1), 3};
  superpixels.labels(cv::Rect(20, 0, 20, 40)).setTo(1);
  superpixels.labels(cv::Rect(40, 0, 20, 40)).setTo(2);
  superpixels.labels(cv::Rect(20, 10, 20, 30)).setTo(2);  // 1 meets 0 along 10 px, 2 along 10 + 20
  cues.residual_px(cv::Rect(0, 0, 20, 40)).setTo(3);
  const Features features = detail::foreground_features(region_graph(cues, superpixels), 1, cues);
  EXPECT_EQ(features[0], 1);
  EXPECT_EQ(features[of_foreground::known], 1);
  EXPECT_EQ(features[of_foreground::raised], 0);
  EXPECT_EQ(features[of_foreground::on_plane], 1);
  EXPECT_FLOAT_EQ(features[of_foreground::raised_around], 0.25F);
  EXPECT_EQ(features[of_foreground::weakest_colour_step], 0);
}

}  // namespace
}  // namespace graspctx
