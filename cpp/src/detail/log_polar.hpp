#pragma once
#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "graspctx/shape_context.hpp"

namespace graspctx::detail {

/// The bins of the log-polar histogram of each point that the others fall into. Arguments as of
/// shape_contexts, which has checked them; they must outlive this.
class LogPolarBins {
 public:
  LogPolarBins(const std::vector<cv::Point2f>& points, const ShapeContextOptions& options,
               const std::vector<float>& gradients_rad, const std::vector<float>& border_px);

  /// Calls visit(column) for each column of the histogram of `from` that counts `to`: none if it is the point
  /// itself or too far away, two if `to` is of the outline and that has a histogram of its own.
  template <typename Visit>
  void visit(std::size_t from, std::size_t to, const Visit& visit) const {
    const int column = bin(from, to);
    if (column < 0) return;
    visit(column);
    if (options_.outline_px > 0 && border_px_[to] <= static_cast<float>(options_.outline_px)) {
      visit(options_.angular_bins * options_.radial_bins + column);
    }
  }

  /// The outer radius of each ring.
  std::vector<double> ring_radii_px() const;

 private:
  int bin(std::size_t from, std::size_t to) const;

  const std::vector<cv::Point2f>& points_;
  const ShapeContextOptions& options_;
  const std::vector<float>&gradients_rad_, &border_px_;
  double unit_px_ = 1;         // the mean pairwise distance
  std::vector<double> radii_;  // outer radius of each ring, in that unit
};

}  // namespace graspctx::detail
