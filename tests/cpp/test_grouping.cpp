#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "blank_cues.hpp"
#include "detail/grouping.hpp"
#include "detail/tree_ensemble.hpp"
#include "same_regions.hpp"
#include "strips.hpp"

namespace graspctx {
namespace {

using detail::Features;
using detail::Grouping;
using detail::Region;
using detail::region_graph;
using detail::RegionGraph;
using detail::SceneCues;
using detail::Superpixels;
using testing::all_foreground;
using testing::grown;
using testing::strips;
using testing::tiles;

const cv::Size image_size(60, 40);

/// The lowest region of the group that each region ended in; -1 for those that took no part.
std::vector<int> groups_of(const Grouping& grouping, int regions) {
  std::vector<int> result(std::size_t(regions), -1);
  // Later groups hold earlier ones.
  for (int group = 0; group < int(grouping.groups().size()); ++group) {
    const std::vector<int> parts = grouping.regions_of(group);
    for (const int region : parts) {
      result[std::size_t(region)] = *std::min_element(parts.begin(), parts.end());
    }
  }
  return result;
}

/// The groups that have not become part of another.
std::vector<int> last_groups(const Grouping& grouping) {
  std::vector<int> last;
  for (int group = 0; group < int(grouping.groups().size()); ++group) {
    if (grouping.groups()[std::size_t(group)].next_probability == 0) last.push_back(group);
  }
  return last;
}

TEST(Grouping, BeginsWithEachRegionByItself) {
  const Grouping grouping(strips(4));
  EXPECT_EQ(groups_of(grouping, 4), (std::vector<int>{0, 1, 2, 3}));
}

TEST(Grouping, TheMostProbableUnionHappensFirst) {
  // Once two are one, nothing else goes with them: which two shows which was first.
  for (int best = 0; best < 4; ++best) {
    Grouping grouping(strips(5));
    grouping.run(
        [&](int a, int b, const Features& features) {
          return grown(features) ? 0.0 : std::min(a, b) == best ? 0.9 : 0.6 + 0.05 * std::min(a, b);
        },
        0.5);
    const std::vector<int> groups = groups_of(grouping, 5);
    EXPECT_EQ(groups[std::size_t(best)], groups[std::size_t(best) + 1]) << best;
    if (best > 0) {
      EXPECT_NE(groups[std::size_t(best) - 1], groups[std::size_t(best)]) << best;
    }
  }
}

TEST(Grouping, KeepsToTheLeast) {
  for (const double probability : {0.49, 0.5, 0.51}) {
    Grouping grouping(strips(3));
    grouping.run([&](int, int, const Features&) { return probability; }, 0.5);
    EXPECT_EQ(last_groups(grouping).size(), probability >= 0.5 ? 1u : 3u);
  }
  Grouping grouping(strips(3));
  grouping.run([&](int, int, const Features&) { return std::nan(""); }, 0.5);
  EXPECT_EQ(last_groups(grouping).size(), 3u);
}

TEST(Grouping, AUnionIsJudgedAnewWhenASideHasGrown) {
  // 1 and 2 are improbable until 0 has joined 1.
  Grouping more(strips(3));
  more.run(
      [](int a, int b, const Features& features) {
        return std::min(a, b) == 0 && std::max(a, b) == 1 ? 0.7 : grown(features) ? 0.9 : 0.1;
      },
      0.5);
  EXPECT_EQ(last_groups(more).size(), 1u);
  // And the other way round: 0.8 was right for two strips only.
  Grouping less(strips(3));
  less.run(
      [](int a, int b, const Features& features) {
        return grown(features) ? 0.1 : std::min(a, b) == 0 && std::max(a, b) == 1 ? 0.9 : 0.8;
      },
      0.5);
  EXPECT_EQ(groups_of(less, 3), (std::vector<int>{0, 0, 2}));
}

TEST(Grouping, LittleForegroundTakesNoPart) {
  RegionGraph graph = strips(4);
  graph.regions[1].sums.foreground = 0.19 * graph.regions[1].sums.area;
  graph.regions[2].sums.foreground = 0.21 * graph.regions[2].sums.area;
  Grouping grouping(std::move(graph));
  grouping.run(
      [](int a, int b, const Features&) {
        EXPECT_NE(a, 1);
        EXPECT_NE(b, 1);
        return 1.0;
      },
      0.5);
  EXPECT_EQ(groups_of(grouping, 4), (std::vector<int>{0, -1, 2, 2}));
  EXPECT_EQ(grouping.region(0).ground_px, 20);
  EXPECT_EQ(grouping.region(2).ground_px, 20);
}

TEST(Grouping, OnlyRegionsThatMeetBecomeOne) {
  RegionGraph graph = strips(5);
  graph.regions[2].sums.foreground = 0;
  Grouping grouping(std::move(graph));
  grouping.run([](int, int, const Features&) { return 1.0; }, 0.5);
  EXPECT_EQ(groups_of(grouping, 5), (std::vector<int>{0, 0, -1, 3, 3}));
}

/// A probability of two regions that changes as they grow, and has no order to it.
double arbitrary(int, int, const Features& features) {
  double sum = 0;
  for (const float feature : features) sum += std::isnan(feature) ? 0.3 : double(feature);
  return 0.5 + 0.5 * std::sin(50 * sum);
}

TEST(Grouping, GroupsAreWhatTheirJoinedPixelsAre) {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const SceneCues cues = testing::random_cues(image_size, seed);
    const Superpixels superpixels = tiles(image_size, {7, 6});
    RegionGraph graph = all_foreground(cues, superpixels);
    for (std::size_t i = seed; i < graph.regions.size(); i += 5) graph.regions[i].sums.foreground = 0;
    Grouping grouping(graph);
    grouping.run(arbitrary, 0.6);
    const std::vector<int> groups = last_groups(grouping), group_of = groups_of(grouping, superpixels.count);
    ASSERT_LT(groups.size(), graph.regions.size() / 2);
    ASSERT_GT(groups.size(), 1u);

    Superpixels joined{superpixels.labels.clone(), superpixels.count};
    for (int& label : cv::Mat_<int>(joined.labels)) {
      if (group_of[std::size_t(label)] >= 0) label = group_of[std::size_t(label)];
    }
    RegionGraph truth = region_graph(cues, joined);
    for (const int group : groups) {
      const std::vector<int> parts = grouping.regions_of(group);
      const int number = *std::min_element(parts.begin(), parts.end());
      Region& region = truth.regions[std::size_t(number)];
      region.sums.foreground = region.sums.area;
      for (const auto& [neighbour, border] : truth.borders[std::size_t(number)]) {
        if (group_of[std::size_t(neighbour)] < 0) region.ground_px += border.length_px;
      }
      testing::expect_same_sums(grouping.region(number), region);
      EXPECT_EQ(grouping.region(number).perimeter_px, region.perimeter_px);
      EXPECT_EQ(grouping.region(number).ground_px, region.ground_px);
      const Features& found = grouping.groups()[std::size_t(group)].appearance;
      const Features expected = detail::object_features(truth, number);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        if (std::isnan(expected[i])) {
          EXPECT_TRUE(std::isnan(found[i])) << i;
        } else {
          EXPECT_NEAR(found[i], expected[i], 1e-5 * (1 + std::abs(expected[i]))) << i;
        }
      }
    }
  }
}

TEST(Grouping, AsksWithTheFeaturesOfTheGrownRegions) {
  // What is asked last of two groups that did not become one is what their joined pixels say.
  const SceneCues cues = testing::random_cues(image_size, 8);
  const Superpixels superpixels = tiles(image_size, {6, 5});
  std::map<std::pair<int, int>, Features> last;
  Grouping grouping(all_foreground(cues, superpixels));
  grouping.run(
      [&](int a, int b, const Features& features) {
        last[std::minmax(a, b)] = features;
        return arbitrary(a, b, features);
      },
      0.9);
  const std::vector<int> group_of = groups_of(grouping, superpixels.count);
  Superpixels joined{superpixels.labels.clone(), superpixels.count};
  for (int& label : cv::Mat_<int>(joined.labels)) label = group_of[std::size_t(label)];
  RegionGraph truth = region_graph(cues, joined);
  for (Region& region : truth.regions) region.sums.foreground = region.sums.area;
  int asked = 0;
  for (int a = 0; a < superpixels.count; ++a) {
    for (const auto& [b, border] : truth.borders[std::size_t(a)]) {
      const Region &x = truth.regions[std::size_t(a)], &y = truth.regions[std::size_t(b)];
      if (a > b) continue;
      const Features expected = detail::union_features(x, y, border);
      const auto found = last.find({a, b});
      ASSERT_NE(found, last.end());
      for (std::size_t i = 0; i < expected.size(); ++i) {
        if (std::isnan(expected[i]) && std::isnan(found->second[i])) continue;
        EXPECT_NEAR(found->second[i], expected[i], 1e-4 * (1 + std::abs(expected[i]))) << i;
      }
      ++asked;
    }
  }
  EXPECT_GT(asked, 5);
}

TEST(Grouping, AllAsOneHasNoBorderLeft) {
  const Superpixels superpixels = tiles(image_size, {7, 6});
  Grouping grouping(all_foreground(testing::random_cues(image_size, 9), superpixels));
  grouping.run([](int, int, const Features&) { return 1.0; }, 0.5);
  ASSERT_EQ(last_groups(grouping).size(), 1u);
  EXPECT_EQ(grouping.region(0).sums.area, image_size.area());
  EXPECT_EQ(grouping.region(0).perimeter_px, 0);
  EXPECT_EQ(groups_of(grouping, superpixels.count), std::vector<int>(std::size_t(superpixels.count), 0));
}

TEST(Grouping, IsTheSameTwice) {
  const Superpixels superpixels = tiles(image_size, {7, 6});
  const RegionGraph graph = all_foreground(testing::random_cues(image_size, 10), superpixels);
  for (const auto& probability : {detail::UnionProbability(arbitrary),
                                  detail::UnionProbability([](int a, int b, const Features&features) {
                                    return (a + b) % 3 == 0 || grown(features) ? 0.2 : 0.8;  // ties
                                  })}) {
    Grouping one(graph), other(graph);
    one.run(probability, 0.5);
    other.run(probability, 0.5);
    EXPECT_EQ(groups_of(one, superpixels.count), groups_of(other, superpixels.count));
    const std::size_t before = one.groups().size();
    one.run(probability, 0.5);  // nothing is left to do
    EXPECT_EQ(one.groups().size(), before);
  }
}

TEST(Grouping, TellsHowProbableEachUnionWas) {
  Grouping grouping(strips(3));
  grouping.run([](int, int, const Features& features) { return grown(features) ? 0.6 : 0.9; }, 0.5);
  ASSERT_EQ(grouping.groups().size(), 5u);
  const detail::Group &first = grouping.groups()[3], &second = grouping.groups()[4];
  EXPECT_EQ(first.union_probability, 0.9);
  EXPECT_EQ(first.next_probability, 0.6);
  EXPECT_EQ(second.union_probability, 0.6);
  EXPECT_EQ(second.next_probability, 0);
  const Features features = grouping.features_of(4);
  const std::size_t own = second.appearance.size();
  ASSERT_EQ(features.size(), own + 3);
  EXPECT_FLOAT_EQ(features[own], 0.6F);
  EXPECT_FLOAT_EQ(features[own + 1], 0);
  EXPECT_FLOAT_EQ(features[own + 2], 0.9F);
  EXPECT_TRUE(std::isnan(grouping.features_of(0)[own + 2]));  // a single region
}

TEST(Grouping, AnEmptyGraphHasNoGroups) {
  Grouping grouping(RegionGraph{});
  grouping.run([](int, int, const Features&) { return 1.0; }, 0.5);
  EXPECT_TRUE(grouping.groups().empty());
}

// Tree 0: f0 <= 1 ? 0.5 : (f1 <= -2 ? -1 : 2), f0 missing to the right, f1 missing to the left.
// Tree 1: f1 <= 0.25 ? -0.75 : 0.125, missing to the right.
constexpr detail::TreeNode nodes[] = {{1, 0, 2, false},       {0.5F, -1, 0, false},  {-2, 1, 4, true},
                                      {-1, -1, 0, false},     {2, -1, 0, false},     {0.25F, 1, 2, false},
                                      {-0.75F, -1, 0, false}, {0.125F, -1, 0, false}};
constexpr int roots[] = {0, 5};
constexpr float missing = std::numeric_limits<float>::quiet_NaN();

double log_odds(const detail::TreeEnsemble& trees, std::array<float, 2> features) {
  const double p = trees.probability(features.data());
  return std::log(p / (1 - p));
}

TEST(TreeEnsemble, AddsTheLeavesByHand) {
  const detail::TreeEnsemble trees{nodes, roots, 2, -0.3};
  EXPECT_NEAR(log_odds(trees, {0, 0}), -0.3 + 0.5 - 0.75, 1e-12);
  EXPECT_NEAR(log_odds(trees, {0, 1}), -0.3 + 0.5 + 0.125, 1e-12);
  EXPECT_NEAR(log_odds(trees, {2, -3}), -0.3 - 1 - 0.75, 1e-12);
  EXPECT_NEAR(log_odds(trees, {2, 0}), -0.3 + 2 - 0.75, 1e-12);
  EXPECT_NEAR(log_odds(trees, {2, 1}), -0.3 + 2 + 0.125, 1e-12);
}

TEST(TreeEnsemble, AThresholdItselfGoesLeft) {
  const detail::TreeEnsemble trees{nodes, roots, 2, 0};
  EXPECT_NEAR(log_odds(trees, {1, 0.25F}), 0.5 - 0.75, 1e-12);
  EXPECT_NEAR(log_odds(trees, {std::nextafter(1.0F, 2.0F), -2}), -1 - 0.75, 1e-12);
}

TEST(TreeEnsemble, WhatIsMissingGoesWhereTheNodeSays) {
  const detail::TreeEnsemble trees{nodes, roots, 2, 0};
  EXPECT_NEAR(log_odds(trees, {missing, 0}), 2 - 0.75, 1e-12);
  EXPECT_NEAR(log_odds(trees, {missing, missing}), -1 + 0.125, 1e-12);
  EXPECT_NEAR(log_odds(trees, {0, missing}), 0.5 + 0.125, 1e-12);
}

TEST(TreeEnsemble, WithoutATreeIsItsBase) {
  const detail::TreeEnsemble none{nullptr, nullptr, 0, 0.4};
  EXPECT_NEAR(none.probability(nullptr), 1 / (1 + std::exp(-0.4)), 1e-12);
}

}  // namespace
}  // namespace graspctx
