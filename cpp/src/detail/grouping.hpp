#pragma once
#include <functional>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "detail/region_features.hpp"
#include "detail/regions.hpp"

namespace graspctx::detail {

/// Sets each region's foreground: how probably it is part of an object.
void judge_foreground(RegionGraph& graph, const SceneCues& cues);

/// How probably two regions that meet are parts of one object. The numbers are the regions' own.
using UnionProbability = std::function<double(int a, int b, const Features& features)>;
double learnt_union_probability(int a, int b, const Features& features);
/// Unions go on as long as they are this probable: which of them were right is for whole_objects.hpp.
constexpr double least_union_probability = 0.02;

/// A region, or the union of two groups.
struct Group {
  int region = -1;               // of a single one, its number
  int left = -1, right = -1;     // of a union, the groups it was made of
  double union_probability = 1;  // of that union
  double next_probability = 0;   // of the union that it became part of; 0 if of none
  Features appearance;           // see object_features
};

/// Regions that grow together: those of which it is most probable first, as long as it is as probable as
/// `least`. Only what is likely foreground takes part.
class Grouping {
 public:
  explicit Grouping(RegionGraph graph);
  void run(const UnionProbability& probability, double least);
  /// All groups there were: first the regions that take part, then the unions in their order.
  const std::vector<Group>& groups() const { return groups_; }
  /// The regions of a group, in no order.
  std::vector<int> regions_of(int group) const;
  /// See object_features; with what is known of the unions.
  Features features_of(int group) const;
  double area_of_region(int number) const { return areas_[std::size_t(number)]; }
  /// The regions that a single one meets, and along how many px.
  const std::vector<std::pair<int, double>>& meets(int number) const { return meets_[std::size_t(number)]; }
  const Region& region(int number) const { return graph_.regions[std::size_t(number)]; }

 private:
  void join(int a, int b, double probability);

  RegionGraph graph_;
  std::vector<double> areas_;  // of the single regions
  std::vector<std::vector<std::pair<int, double>>> meets_;
  std::vector<Group> groups_;
  std::vector<int> group_of_;  // by region: the group it now stands for, or -1
};

}  // namespace graspctx::detail
