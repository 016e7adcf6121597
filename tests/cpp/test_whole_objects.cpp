#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "detail/whole_objects.hpp"
#include "strips.hpp"

namespace graspctx {
namespace {

using detail::Features;
using detail::Grouping;
using detail::RegionGraph;
using testing::all_foreground;
using testing::grown;
using testing::strips;
using testing::tiles;

/// Three strips that have become one, first the left two.
Grouping joined_strips() {
  Grouping grouping(strips(3));
  grouping.run(
      [](int a, int b, const Features& features) { return grown(features) ? 0.6 : 0.9 - 0.1 * (a + b > 1); },
      0.5);
  return grouping;
}

/// Their whole objects; what each group is thought to be is given.
std::vector<std::vector<int>> wholes(std::map<std::vector<int>, double> probabilities, double least) {
  const Grouping grouping = joined_strips();
  std::vector<double> in_order;
  for (int group = 0; group < int(grouping.groups().size()); ++group) {
    std::vector<int> parts = grouping.regions_of(group);
    std::sort(parts.begin(), parts.end());
    in_order.push_back(probabilities.at(parts));
  }
  const std::vector<int> found = detail::whole_objects(grouping, in_order, least);
  std::vector<std::vector<int>> result;
  for (const int group : found) {
    result.push_back(grouping.regions_of(group));
    std::sort(result.back().begin(), result.back().end());
  }
  std::sort(result.begin(), result.end());
  return result;
}

TEST(WholeObjects, AreWorthMoreThanTheirParts) {
  using Found = std::vector<std::vector<int>>;
  const std::vector<int> a{0}, b{1}, c{2}, ab{0, 1}, all{0, 1, 2};
  // The union of two is the object, and the third one by itself.
  EXPECT_EQ(wholes({{a, 0.1}, {b, 0.2}, {c, 0.8}, {ab, 0.9}, {all, 0.4}}, 0.3), (Found{ab, c}));
  // All together.
  EXPECT_EQ(wholes({{a, 0.1}, {b, 0.2}, {c, 0.5}, {ab, 0.6}, {all, 0.95}}, 0.3), (Found{all}));
  // Each by itself, two more probable than their union is alone.
  EXPECT_EQ(wholes({{a, 0.7}, {b, 0.7}, {c, 0.1}, {ab, 0.9}, {all, 0.4}}, 0.1), (Found{a, b}));
  // A least that takes the gain of two objects from them.
  EXPECT_EQ(wholes({{a, 0.7}, {b, 0.7}, {c, 0.1}, {ab, 0.9}, {all, 0.4}}, 0.6), (Found{ab}));
  // None.
  EXPECT_EQ(wholes({{a, 0.1}, {b, 0.2}, {c, 0.1}, {ab, 0.2}, {all, 0.25}}, 0.3), Found{});
}

/// Of three strips, the last three features of each group in context: the share of its border along which the
/// best of the groups around it lies, how good that one is and how large.
std::vector<std::array<float, 3>> around(const std::vector<double>& by_itself) {
  const Grouping grouping = joined_strips();
  std::vector<std::array<float, 3>> result;
  for (const Features& features : detail::features_in_context(grouping, by_itself)) {
    result.push_back({features.end()[-3], features.end()[-2], features.end()[-1]});
  }
  return result;
}

TEST(WholeObjects, AreJudgedBesideWhatLiesAroundThem) {
  // 10 px wide and 20 high, side by side over the whole picture: they meet nothing else.
  const auto apart = around({0.5, 0.2, 0.8, 0.6, 0.1});  // the left two are best as one
  EXPECT_EQ(apart[2], (std::array<float, 3>{1, 0.6F, 2}));
  EXPECT_EQ(apart[3], (std::array<float, 3>{1, 0.8F, 0.5F}));
  EXPECT_EQ(apart[1][0], 0.5F);  // half of its border is the third's, the other within what it is part of
  EXPECT_EQ(apart[1][1], 0.8F);
  EXPECT_EQ(apart[0][0], 0);  // it meets only what it is part of
  EXPECT_TRUE(std::isnan(apart[0][1]) && std::isnan(apart[0][2]));
  // Where all are best as one, none has anything around it.
  for (const auto& group : around({0.5, 0.2, 0.8, 0.6, 0.9})) {
    EXPECT_EQ(group[0], 0);
    EXPECT_TRUE(std::isnan(group[1]));
  }
}

TEST(WholeObjects, GroundAroundThemIsPartOfTheBorder) {
  const cv::Size size(40, 20);
  RegionGraph graph = all_foreground(testing::blank_cues(size), tiles(size, {10, 20}));
  graph.regions[0].sums.foreground = 0;
  const Grouping grouping(std::move(graph));  // 1, 2 and 3 take part, no unions
  const auto features = detail::features_in_context(grouping, {0.3, 0.5, 0.7});
  EXPECT_EQ(features[0].end()[-3], 0.5F);
  EXPECT_EQ(features[0].end()[-2], 0.5F);
  EXPECT_EQ(features[1].end()[-3], 0.5F);
  EXPECT_EQ(features[2].end()[-3], 1);
}

TEST(WholeObjects, AreJudgedBesideTheirPartsAndWhatTheyArePartOf) {
  const Grouping grouping = joined_strips();
  const std::vector<double> by_itself{0.1, 0.2, 0.3, 0.9, 0.4};  // a, b, c, ab, abc
  const std::vector<Features> in_context = detail::features_in_context(grouping, by_itself);
  ASSERT_EQ(in_context.size(), 5u);
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  // Itself, the union it became part of, what it was joined with and its size, the best above and its size,
  // the better and the worse part.
  const float expected[5][8] = {{0.1F, 0.9F, 0.2F, 1, 0.9F, 2, none, none},
                                {0.2F, 0.9F, 0.1F, 1, 0.9F, 2, none, none},
                                {0.3F, 0.4F, 0.9F, 2, 0.4F, 3, none, none},
                                {0.9F, 0.4F, 0.3F, 0.5F, 0.4F, 1.5F, 0.2F, 0.1F},
                                {0.4F, none, none, none, none, none, 0.9F, 0.3F}};
  for (std::size_t group = 0; group < 5; ++group) {
    const Features own = grouping.features_of(int(group));
    ASSERT_EQ(in_context[group].size(), own.size() + 11);
    for (std::size_t i = 0; i < 8; ++i) {
      const float found = in_context[group][own.size() + i];
      if (std::isnan(expected[group][i])) {
        EXPECT_TRUE(std::isnan(found)) << group << ", " << i;
      } else {
        EXPECT_FLOAT_EQ(found, expected[group][i]) << group << ", " << i;
      }
    }
  }
}

}  // namespace
}  // namespace graspctx
