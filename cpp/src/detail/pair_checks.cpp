#include "detail/pair_checks.hpp"

#include <cmath>
#include <opencv2/core.hpp>

#include "detail/texture.hpp"

namespace graspctx::detail {

namespace {

/// Share of the textured pixels whose disparity both views agree on. Of two views that show different
/// scenes, or that are swapped, hardly any do.
double reliable_share(const cv::Mat& left, const Disparity& disparity) {
  constexpr double texture_sigmas = 3;  // well textured: a failure there is the pair's, not the table's
  const cv::Mat textured = horizontal_texture(left, texture_sigmas);
  int known = 0, all = 0;
  for (int v = 0; v < left.rows; ++v) {
    const auto* dense = disparity.dense.ptr<float>(v);
    const auto* reliable = disparity.reliable.ptr<float>(v);
    const auto* here = textured.ptr<uchar>(v);
    // The leftmost columns may lie outside the right view.
    for (int u = left.cols / 8; u < left.cols; ++u) {
      if (!here[u]) continue;
      ++all;
      known += !std::isnan(dense[u]) && !std::isnan(reliable[u]) ? 1 : 0;
    }
  }
  return all > 0 ? static_cast<double>(known) / all : 0;
}

/// The same picture twice has no depth.
bool are_the_same_view(const cv::Mat& left, const cv::Mat& right) {
  const double difference = cv::norm(left, right, cv::NORM_L1) / static_cast<double>(left.total());
  return difference < 0.5 * noise_sigma(left);
}

}  // namespace

std::optional<std::string> why_no_stereo_pair(const RectifiedPair& pair, const Disparity& disparity,
                                              double min_reliable_share) {
  const cv::Mat left = grey(pair.left), right = grey(pair.right);
  if (are_the_same_view(left, right)) return "the two views are the same picture: there is no depth in them";
  const double share = reliable_share(left, disparity);
  if (share >= min_reliable_share) return std::nullopt;
  return "only " + std::to_string(static_cast<int>(100 * share)) +
         " % of the textured pixels agree between the views: not a rectified stereo pair of one scene, left "
         "view "
         "first";
}

}  // namespace graspctx::detail
