#include "detail/whole_objects.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "detail/grouping_trees.hpp"

namespace graspctx::detail {

namespace {

/// How the groups lie beside each other.
class Surroundings {
 public:
  Surroundings(const Grouping& grouping, const std::vector<double>& by_itself)
      : grouping_(grouping), first_(grouping.groups().size(), -1), size_(first_.size(), 1) {
    const std::vector<Group>& groups = grouping.groups();
    // The regions in an order in which those of any group follow each other.
    for (std::size_t i = 0; i < groups.size(); ++i) {
      if (groups[i].left >= 0) size_[i] = size_[at(groups[i].left)] + size_[at(groups[i].right)];
    }
    std::vector<int> best(groups.size());  // of the group and all that hold it
    int next = 0;
    for (std::size_t i = groups.size(); i-- > 0;) {
      if (first_[i] < 0) {  // part of nothing
        first_[i] = next;
        next += size_[i];
        best[i] = static_cast<int>(i);
      }
      if (groups[i].left < 0) continue;
      first_[at(groups[i].left)] = first_[i];
      first_[at(groups[i].right)] = first_[i] + size_[at(groups[i].left)];
      for (const int part : {groups[i].left, groups[i].right}) {
        best[at(part)] = by_itself[at(part)] >= by_itself[at(best[i])] ? part : best[i];
      }
    }
    for (std::size_t i = 0; i < groups.size(); ++i) {
      if (groups[i].region >= 0) regions_[groups[i].region] = {static_cast<int>(i), best[i]};
    }
  }

  struct Neighbour {
    int group = -1;           // none
    double border_share = 0;  // of the whole border
  };
  /// Of the groups that are the best that each region around is part of, the one that meets most of the
  /// border.
  Neighbour main_neighbour(int group) const {
    double length_px = 0;
    std::map<int, double> meeting_px;
    for (const int region : grouping_.regions_of(group)) {
      for (const auto& [other, border_px] : grouping_.meets(region)) {
        const auto there = regions_.find(other);
        const bool takes_part = there != regions_.end();
        if (takes_part && holds(group, there->second.own)) continue;
        length_px += border_px;
        if (takes_part && !holds(there->second.best, group)) meeting_px[there->second.best] += border_px;
      }
    }
    Neighbour main;
    for (const auto& [other, px] : meeting_px) {
      if (px / length_px > main.border_share) main = {other, px / length_px};
    }
    return main;
  }

 private:
  static std::size_t at(int index) { return static_cast<std::size_t>(index); }
  bool holds(int group, int part) const {
    return first_[at(group)] <= first_[at(part)] &&
           first_[at(part)] + size_[at(part)] <= first_[at(group)] + size_[at(group)];
  }
  struct Groups {
    int own, best;
  };
  const Grouping& grouping_;
  std::vector<int> first_, size_;
  std::map<int, Groups> regions_;  // those that take part
};

}  // namespace

std::vector<Features> features_in_context(const Grouping& grouping, const std::vector<double>& by_itself) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Group>& groups = grouping.groups();
  struct Context {
    double area = 0, best = 0;               // of the group and all its parts
    double whole = none;                     // that of the union it became part of
    double other = none, other_area = none;  // the best of what it was joined with, and how large that is
    double above = none, above_area = none;  // the best of all unions that hold it
    double better_part = none, worse_part = none;
  };
  std::vector<Context> contexts(groups.size());
  for (std::size_t i = 0; i < groups.size(); ++i) {  // parts come before what they make
    Context& own = contexts[i];
    own.best = by_itself[i];
    if (groups[i].left < 0) {
      own.area = grouping.area_of_region(groups[i].region);
      continue;
    }
    const Context &left = contexts[std::size_t(groups[i].left)],
                  &right = contexts[std::size_t(groups[i].right)];
    own.area = left.area + right.area;
    own.better_part = std::max(left.best, right.best);
    own.worse_part = std::min(left.best, right.best);
    own.best = std::max(own.best, own.better_part);
  }
  for (std::size_t i = groups.size(); i-- > 0;) {
    if (groups[i].left < 0) continue;
    const Context& whole = contexts[i];
    for (const auto& [part, other] :
         {std::pair(groups[i].left, groups[i].right), std::pair(groups[i].right, groups[i].left)}) {
      Context& own = contexts[std::size_t(part)];
      own.whole = by_itself[i];
      own.other = contexts[std::size_t(other)].best;
      own.other_area = contexts[std::size_t(other)].area;
      const bool is_better = !(whole.above > by_itself[i]);
      own.above = is_better ? by_itself[i] : whole.above;
      own.above_area = is_better ? whole.area : whole.above_area;
    }
  }
  const Surroundings surroundings(grouping, by_itself);
  std::vector<Features> result;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    result.push_back(grouping.features_of(static_cast<int>(i)));
    const Context& own = contexts[i];
    const auto [beside, border_share] = surroundings.main_neighbour(static_cast<int>(i));
    const double beside_best = beside < 0 ? none : by_itself[std::size_t(beside)];
    const double beside_area = beside < 0 ? none : contexts[std::size_t(beside)].area;
    for (const double value :
         {by_itself[i], own.whole, own.other, own.other_area / own.area, own.above, own.above_area / own.area,
          own.better_part, own.worse_part, border_share, beside_best, beside_area / own.area}) {
      result.back().push_back(static_cast<float>(value));
    }
  }
  return result;
}

std::vector<double> learnt_probabilities_by_itself(const Grouping& grouping) {
  std::vector<double> probabilities;
  for (int group = 0; group < static_cast<int>(grouping.groups().size()); ++group) {
    probabilities.push_back(object_trees.probability(grouping.features_of(group).data()));
  }
  return probabilities;
}

std::vector<double> learnt_probabilities(const Grouping& grouping) {
  std::vector<double> probabilities;
  for (const Features& features : features_in_context(grouping, learnt_probabilities_by_itself(grouping))) {
    probabilities.push_back(whole_trees.probability(features.data()));
  }
  return probabilities;
}

std::vector<int> whole_objects(const Grouping& grouping, const std::vector<double>& probabilities,
                               double least) {
  // The best of a union is itself, or the best of its parts; parts come before what they make.
  const std::vector<Group>& groups = grouping.groups();
  std::vector<double> worth(groups.size());
  std::vector<bool> whole(groups.size()), is_part(groups.size());
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const Group& group = groups[i];
    double of_parts = 0;
    for (const int part : {group.left, group.right}) {
      if (part < 0) continue;
      of_parts += worth[static_cast<std::size_t>(part)];
      is_part[static_cast<std::size_t>(part)] = true;
    }
    const double own = probabilities[i] - least;
    whole[i] = own >= of_parts && own > 0;
    worth[i] = std::max(own, of_parts);
  }
  std::vector<int> found, open;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (!is_part[i]) open.push_back(static_cast<int>(i));
  }
  while (!open.empty()) {
    const int next = open.back();
    open.pop_back();
    const Group& group = groups[static_cast<std::size_t>(next)];
    if (whole[static_cast<std::size_t>(next)]) {
      found.push_back(next);
    } else if (group.left >= 0) {
      open.push_back(group.left);
      open.push_back(group.right);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace graspctx::detail
