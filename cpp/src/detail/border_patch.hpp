#pragma once

namespace graspctx::detail {

/// A patch of which less than half is labelled: on the border of the region, neither right nor wrong.
inline bool is_border_patch(int label, float label_share) {
  return label == 1 && label_share < 0.5f;
}

}  // namespace graspctx::detail
