#include "detail/relief.hpp"

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "detail/plane_geometry.hpp"
#include "detail/sgbm.hpp"
#include "detail/texture.hpp"

namespace graspctx::detail {

Relief relief_over_plane(const RectifiedPair& pair, const Disparity& disparity, const TablePlane& plane) {
  const cv::Size size = pair.left.size();
  Relief relief;
  cv::Mat map_u(size, CV_32FC1), map_v(size, CV_32FC1);
  relief.inside.create(size, CV_8UC1);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const double u_right = u - plane_disparity(plane, u, v);
      map_u.at<float>(v, u) = static_cast<float>(u_right);
      map_v.at<float>(v, u) = static_cast<float>(v);
      relief.inside.at<uchar>(v, u) = u_right >= 0 && u_right <= size.width - 1 ? 255 : 0;
    }
  }
  cv::remap(pair.right, relief.table_view, map_u, map_v, cv::INTER_LINEAR, cv::BORDER_REPLICATE);

  constexpr int lowest_px = -4, range = 32;
  MatcherSettings settings;
  settings.min_disparity_px = lowest_px;
  settings.disparities = range;
  const cv::Mat left_fine = match_semi_global(pair.left, relief.table_view, settings);
  const cv::Mat right_fine = match_semi_global_right(pair.left, relief.table_view, settings);
  cv::Mat fine = keep_consistent(left_fine, right_fine, 1.0);
  constexpr double texture_sigmas = 1.5;
  fine.setTo(std::numeric_limits<float>::quiet_NaN(), ~horizontal_texture(grey(pair.left), texture_sigmas));

  // The warp stretches rows by 1 - alpha: a disparity s there is one of s·(1 - alpha) here.
  const auto stretch = static_cast<float>(1 - plane.alpha);
  constexpr float top_px = lowest_px + range - 6;
  relief.residual_px.create(size, CV_32FC1);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const float coarse =
          disparity.reliable.at<float>(v, u) - static_cast<float>(plane_disparity(plane, u, v));
      const float near = fine.at<float>(v, u) * stretch;
      const bool out_of_range = coarse > top_px || coarse < lowest_px + 1;
      relief.residual_px.at<float>(v, u) = out_of_range ? coarse : near;
    }
  }
  return relief;
}

}  // namespace graspctx::detail
