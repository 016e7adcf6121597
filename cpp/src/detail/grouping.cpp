#include "detail/grouping.hpp"

#include <algorithm>
#include <queue>
#include <tuple>
#include <utility>

#include "detail/grouping_trees.hpp"

namespace graspctx::detail {

namespace {
constexpr double least_foreground = 0.4;
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

Grouping::Grouping(RegionGraph graph) : graph_(std::move(graph)), joined_to_(graph_.regions.size(), -1) {
  for (std::size_t i = 0; i < joined_to_.size(); ++i) {
    const RegionSums& sums = graph_.regions[i].sums;
    if (sums.foreground > least_foreground * sums.area) joined_to_[i] = static_cast<int>(i);
  }
  for (std::size_t i = 0; i < joined_to_.size(); ++i) {
    for (const auto& [neighbour, border] : graph_.borders[i]) {
      if (joined_to_[static_cast<std::size_t>(neighbour)] < 0)
        graph_.regions[i].ground_px += border.length_px;
    }
  }
}

void Grouping::run(const UnionProbability& probability, double least) {
  // A union is out of date as soon as either of its regions has grown.
  using Union = std::tuple<double, int, int, int>;  // probability, -a, -b, how often the two had grown
  std::priority_queue<Union> unions;
  std::vector<int> grown(graph_.regions.size(), 0);
  const auto times_grown = [&](int a, int b) {
    return grown[static_cast<std::size_t>(a)] + grown[static_cast<std::size_t>(b)];
  };
  const auto consider = [&](int a, int b, const Border& border) {
    if (joined_to_[static_cast<std::size_t>(a)] != a || joined_to_[static_cast<std::size_t>(b)] != b) return;
    const double p = probability(a, b, union_features(region(a), region(b), border));
    if (p >= least) unions.emplace(p, -std::min(a, b), -std::max(a, b), times_grown(a, b));
  };
  for (int a = 0; a < static_cast<int>(graph_.regions.size()); ++a) {
    for (const auto& [b, border] : graph_.borders[static_cast<std::size_t>(a)]) {
      if (a < b) consider(a, b, border);
    }
  }
  while (!unions.empty()) {
    const auto [p, minus_a, minus_b, times] = unions.top();
    unions.pop();
    const int a = -minus_a, b = -minus_b;
    const bool still_groups =
        joined_to_[static_cast<std::size_t>(a)] == a && joined_to_[static_cast<std::size_t>(b)] == b;
    if (!still_groups || times != times_grown(a, b)) continue;
    join(a, b);
    ++grown[static_cast<std::size_t>(a)];
    for (const auto& [c, border] : graph_.borders[static_cast<std::size_t>(a)]) consider(a, c, border);
  }
}

void Grouping::join(int a, int b) {
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
  joined_to_[static_cast<std::size_t>(b)] = a;
}

std::vector<int> Grouping::groups() const {
  std::vector<int> result;
  for (int i = 0; i < static_cast<int>(joined_to_.size()); ++i) {
    if (joined_to_[static_cast<std::size_t>(i)] == i) result.push_back(i);
  }
  return result;
}

int Grouping::group_of(int region) const {
  while (region >= 0 && joined_to_[static_cast<std::size_t>(region)] != region) {
    region = joined_to_[static_cast<std::size_t>(region)];
  }
  return region;
}

Features Grouping::features_of(int group) const {
  Border all_around;
  for (const auto& [neighbour, border] : graph_.borders[static_cast<std::size_t>(group)])
    all_around.add(border);
  return object_features(region(group), all_around);
}

}  // namespace graspctx::detail
