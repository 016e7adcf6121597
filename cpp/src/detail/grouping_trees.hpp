#pragma once
#include "detail/tree_ensemble.hpp"

namespace graspctx::detail {

// Made by tools/train_grouping, see there.
extern const TreeEnsemble foreground_trees;
extern const TreeEnsemble union_trees;
extern const TreeEnsemble object_trees;
extern const TreeEnsemble whole_trees;

}  // namespace graspctx::detail
