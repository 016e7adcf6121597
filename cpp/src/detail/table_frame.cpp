#include "detail/table_frame.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detail/masks.hpp"
#include "detail/plane_geometry.hpp"

namespace graspctx::detail {

namespace {

/// The pixels of the larger pieces of table. A wall or floor that crosses the plane lies on it along a line
/// only: look at the share in a window.
cv::Mat pixels_on_plane(const Relief& relief, double within_px) {
  const cv::Size size = relief.residual_px.size();
  cv::Mat on_plane(size, CV_32FC1), off_plane(size, CV_32FC1);
  for (int v = 0; v < size.height; ++v) {
    const auto* residual = relief.residual_px.ptr<float>(v);
    for (int u = 0; u < size.width; ++u) {
      on_plane.at<float>(v, u) = std::abs(residual[u]) < within_px ? 1.0F : 0.0F;
      off_plane.at<float>(v, u) = std::abs(residual[u]) >= within_px ? 1.0F : 0.0F;
    }
  }
  const cv::Mat itself = on_plane > 0;
  const cv::Size window(21, 21);
  cv::boxFilter(on_plane, on_plane, CV_32F, window);
  cv::boxFilter(off_plane, off_plane, CV_32F, window);
  on_plane = (on_plane > off_plane) & (on_plane > 0.15);
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(on_plane, labels, stats, centres, 8, CV_32S);
  int largest = 0;
  for (int label = 1; label < count; ++label) {
    largest = std::max(largest, stats.at<int>(label, cv::CC_STAT_AREA));
  }
  return parts_holding(on_plane, on_plane, largest / 10) & itself;
}

}  // namespace

TableFrame table_frame(const Relief& relief, const TablePlane& plane, const StereoCamera& camera) {
  TableFrame frame;
  frame.right = (Eigen::Vector3d::UnitX() - plane.normal.x() * plane.normal).normalized();
  frame.nearer = frame.right.cross(plane.normal);
  std::vector<cv::Point2f> points;
  for (const cv::Point& pixel : where(pixels_on_plane(relief, std::max(0.5, 2 * plane.sigma_px)))) {
    if ((pixel.x + pixel.y) % 3 != 0) continue;
    const double d = plane_disparity(plane, pixel.x, pixel.y);
    if (d + camera.doffs_px <= 0) continue;
    points.push_back(frame.of(camera.triangulate({double(pixel.x), double(pixel.y)}, d)));
  }
  if (points.size() >= 3) cv::convexHull(points, frame.hull);
  return frame;
}

}  // namespace graspctx::detail
