#pragma once
#include <vector>

#include "detail/grouping.hpp"

namespace graspctx::detail {

/// Of each group, features_of beside how it compares with its parts, with what it is part of, and with what
/// lies around it. by_itself: how probably each group is a whole object.
std::vector<Features> features_in_context(const Grouping& grouping, const std::vector<double>& by_itself);

/// How probably each group is a whole object: by itself, and then among the others.
std::vector<double> learnt_probabilities_by_itself(const Grouping& grouping);
std::vector<double> learnt_probabilities(const Grouping& grouping);

/// Of all groups, those that are the whole objects: no two share a region, and the sum of what they are worth
/// is the largest there is. A group is worth its probability of being a whole object, less `least`.
std::vector<int> whole_objects(const Grouping& grouping, const std::vector<double>& probabilities,
                               double least);

}  // namespace graspctx::detail
