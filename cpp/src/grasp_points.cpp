#include "graspctx/grasp_points.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "detail/check.hpp"

namespace graspctx {

void GraspPointOptions::check() const {
  detail::require_option(max_points >= 1, "max_points must be at least 1");
  detail::require_option(neighbour_ratio >= 0 && neighbour_ratio <= 1, "neighbour_ratio must be 0 to 1");
}

std::vector<GraspPoint> find_grasp_points(const PatchDescriptors& patches,
                                          const Eigen::VectorXd& probabilities,
                                          const GraspPointOptions& options) {
  options.check();
  const std::size_t count = patches.cells.size();
  if (probabilities.size() != static_cast<Eigen::Index>(count)) {
    throw InvalidInput("probabilities: expected one for each of the " + std::to_string(count) +
                       " patches, got " + std::to_string(probabilities.size()));
  }

  // The patch in each cell of the grid, -1 where there is no contour.
  Eigen::ArrayXXi patch_at = Eigen::ArrayXXi::Constant(patches.grid.height + 2, patches.grid.width + 2, -1);
  for (std::size_t i = 0; i < count; ++i) {
    patch_at(patches.cells[i].y + 1, patches.cells[i].x + 1) = static_cast<int>(i);
  }

  std::vector<GraspPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    const auto centre = static_cast<Eigen::Index>(i);
    const double value = probabilities[centre];
    double neighbour_sum = 0;
    int neighbour_count = 0;
    bool is_maximum = true;
    for (int row = 0; row <= 2; ++row) {
      for (int column = 0; column <= 2; ++column) {
        const int neighbour = patch_at(patches.cells[i].y + row, patches.cells[i].x + column);
        if (neighbour < 0 || neighbour == static_cast<int>(i)) continue;
        // On a plateau the first patch in reading order is the maximum.
        const bool beaten = neighbour < static_cast<int>(i) ? probabilities[neighbour] >= value
                                                            : probabilities[neighbour] > value;
        if (beaten) is_maximum = false;
        neighbour_sum += probabilities[neighbour];
        ++neighbour_count;
      }
    }
    // III-D: the 8 neighbours carry values close to the centre's; a lone peak is noise.
    const bool supported =
        neighbour_count > 0 && neighbour_sum >= options.neighbour_ratio * value * neighbour_count;
    if (is_maximum && supported) points.push_back({static_cast<int>(i), patches.centres_px[i], value});
  }

  std::stable_sort(points.begin(), points.end(),
                   [](const GraspPoint& a, const GraspPoint& b) { return a.probability > b.probability; });
  if (points.size() > static_cast<std::size_t>(options.max_points)) {
    points.resize(static_cast<std::size_t>(options.max_points));
  }
  return points;
}

}  // namespace graspctx
