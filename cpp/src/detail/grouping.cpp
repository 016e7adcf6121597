#include "detail/grouping.hpp"

#include <algorithm>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

#include "detail/grouping_trees.hpp"

namespace graspctx::detail {

namespace {
constexpr double least_foreground = 0.2;
}

void judge_foreground(RegionGraph& graph, const SceneCues& cues) {
  for (int region = 0; region < static_cast<int>(graph.regions.size()); ++region) {
    RegionSums& sums = graph.regions[static_cast<std::size_t>(region)].sums;
    sums.foreground =
        sums.area * foreground_trees.probability(foreground_features(graph, region, cues).data());
  }
}

double learnt_union_probability(int, int, const Features& features) {
  return union_trees.probability(features.data());
}

Grouping::Grouping(RegionGraph graph) : graph_(std::move(graph)), group_of_(graph_.regions.size(), -1) {
  for (const Region& region : graph_.regions) areas_.push_back(region.sums.area);
  meets_.resize(graph_.borders.size());
  for (std::size_t i = 0; i < meets_.size(); ++i) {
    for (const auto& [neighbour, border] : graph_.borders[i]) {
      meets_[i].emplace_back(neighbour, border.length_px);
    }
  }
  for (std::size_t i = 0; i < group_of_.size(); ++i) {
    const RegionSums& sums = graph_.regions[i].sums;
    if (!(sums.foreground > least_foreground * sums.area)) continue;
    group_of_[i] = static_cast<int>(groups_.size());
    groups_.emplace_back();
    groups_.back().region = static_cast<int>(i);
  }
  for (std::size_t i = 0; i < group_of_.size(); ++i) {
    for (const auto& [neighbour, border] : graph_.borders[i]) {
      if (group_of_[static_cast<std::size_t>(neighbour)] < 0) graph_.regions[i].ground_px += border.length_px;
    }
  }
  for (Group& group : groups_) group.appearance = object_features(graph_, group.region);
}

void Grouping::run(const UnionProbability& probability, double least) {
  // A union is out of date as soon as either of its groups has become part of another.
  using Union = std::tuple<double, int, int, int, int>;  // probability, -a, -b, their groups
  std::priority_queue<Union> unions;
  const auto group_of = [&](int region) { return group_of_[static_cast<std::size_t>(region)]; };
  const auto consider = [&](int a, int b, const Border& border) {
    if (group_of(a) < 0 || group_of(b) < 0) return;
    if (b < a) std::swap(a, b);
    const double p = probability(a, b, union_features(region(a), region(b), border));
    if (p >= least) unions.emplace(p, -a, -b, group_of(a), group_of(b));
  };
  for (int a = 0; a < static_cast<int>(graph_.regions.size()); ++a) {
    for (const auto& [b, border] : graph_.borders[static_cast<std::size_t>(a)]) {
      if (a < b) consider(a, b, border);
    }
  }
  while (!unions.empty()) {
    const auto [p, minus_a, minus_b, group_a, group_b] = unions.top();
    unions.pop();
    const int a = -minus_a, b = -minus_b;
    if (group_of(a) != group_a || group_of(b) != group_b) continue;
    join(a, b, p);
    for (const auto& [c, border] : graph_.borders[static_cast<std::size_t>(a)]) consider(a, c, border);
  }
}

void Grouping::join(int a, int b, double probability) {
  auto& regions = graph_.regions;
  auto& borders = graph_.borders;
  regions[static_cast<std::size_t>(a)].add(regions[static_cast<std::size_t>(b)]);
  auto& of_a = borders[static_cast<std::size_t>(a)];
  regions[static_cast<std::size_t>(a)].perimeter_px +=
      regions[static_cast<std::size_t>(b)].perimeter_px - 2 * of_a[b].length_px;
  of_a.erase(b);
  for (const auto& [c, border] : borders[static_cast<std::size_t>(b)]) {
    if (c == a) continue;
    auto& of_c = borders[static_cast<std::size_t>(c)];
    of_c.erase(b);
    of_a[c].add(border);
    of_c[a] = of_a[c];
  }
  borders[static_cast<std::size_t>(b)].clear();

  Group joined;
  joined.left = std::exchange(group_of_[static_cast<std::size_t>(a)], static_cast<int>(groups_.size()));
  joined.right = std::exchange(group_of_[static_cast<std::size_t>(b)], -1);
  joined.union_probability = probability;
  joined.appearance = object_features(graph_, a);
  for (const int part : {joined.left, joined.right}) {
    groups_[static_cast<std::size_t>(part)].next_probability = probability;
  }
  groups_.push_back(std::move(joined));
}

std::vector<int> Grouping::regions_of(int group) const {
  std::vector<int> regions, open{group};
  while (!open.empty()) {
    const Group& next = groups_[static_cast<std::size_t>(open.back())];
    open.pop_back();
    if (next.region >= 0) {
      regions.push_back(next.region);
    } else {
      open.push_back(next.left);
      open.push_back(next.right);
    }
  }
  return regions;
}

Features Grouping::features_of(int number) const {
  const Group& group = groups_[static_cast<std::size_t>(number)];
  Features features = group.appearance;
  double before = std::numeric_limits<double>::quiet_NaN();  // the least of the two unions before
  if (group.left >= 0) {
    before = std::min(groups_[static_cast<std::size_t>(group.left)].union_probability,
                      groups_[static_cast<std::size_t>(group.right)].union_probability);
  }
  for (const double value : {group.union_probability, group.next_probability, before}) {
    features.push_back(static_cast<float>(value));
  }
  return features;
}

}  // namespace graspctx::detail
