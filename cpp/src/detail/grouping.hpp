#pragma once
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "detail/region_features.hpp"
#include "detail/regions.hpp"

namespace graspctx::detail {

/// Sets each region's foreground: how probably it is part of an object.
void judge_foreground(RegionGraph& graph, const SceneCues& cues);

/// How probably two regions that meet are parts of one object. The numbers are the regions' own.
using UnionProbability = std::function<double(int a, int b, const Features& features)>;
double learnt_union_probability(int a, int b, const Features& features);
constexpr double least_union_probability = 0.5;

/// Regions that grow together: those of which it is most probable first, as long as it is as probable as
/// `least`. Only what is likely foreground takes part.
class Grouping {
 public:
  explicit Grouping(RegionGraph graph);
  void run(const UnionProbability& probability, double least);
  /// The numbers of the groups that are left; a group has the number of one of its regions.
  std::vector<int> groups() const;
  /// The group of a region, -1 if it took no part.
  int group_of(int region) const;
  const Region& region(int group) const { return graph_.regions[std::size_t(group)]; }
  /// See object_features.
  Features features_of(int group) const;

 private:
  void join(int a, int b);

  RegionGraph graph_;
  std::vector<int> joined_to_;  // -1: took no part; itself: a group
};

}  // namespace graspctx::detail
