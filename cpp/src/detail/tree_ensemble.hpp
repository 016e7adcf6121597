#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace graspctx::detail {

/// Boosted decision trees, as data: see tools/train_grouping.
struct TreeNode {
  float threshold;       // of a leaf: what it adds to the log odds
  std::int16_t feature;  // -1: a leaf
  std::int16_t right;    // index of the right child in the tree's own nodes; the left one comes next
  bool missing_to_left;  // where a feature is not a number
};

struct TreeEnsemble {
  const TreeNode* nodes;
  const int* roots;  // index of each tree's first node
  int trees;
  double base;  // log odds before any tree

  /// features: as many as the trees were trained on; NaN where unknown.
  double probability(const float* features) const {
    double log_odds = base;
    for (int tree = 0; tree < trees; ++tree) {
      const TreeNode* root = nodes + roots[tree];
      const TreeNode* node = root;
      while (node->feature >= 0) {
        const float value = features[node->feature];
        const bool to_left = std::isnan(value) ? node->missing_to_left : value <= node->threshold;
        node = to_left ? node + 1 : root + node->right;
      }
      log_odds += node->threshold;
    }
    return 1 / (1 + std::exp(-log_odds));
  }
};

}  // namespace graspctx::detail
