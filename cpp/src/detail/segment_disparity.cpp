#include "detail/segment_disparity.hpp"

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "detail/quantile.hpp"

namespace graspctx::detail {

namespace {

double median_in(const cv::Rect& window, const cv::Mat& mask, const cv::Mat& disparity) {
  std::vector<float> values;
  for (int v = window.y; v < window.br().y; ++v) {
    for (int u = window.x; u < window.br().x; ++u) {
      if (mask.at<uchar>(v, u) && std::isfinite(disparity.at<float>(v, u))) {
        values.push_back(disparity.at<float>(v, u));
      }
    }
  }
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return median(std::move(values));
}

}  // namespace

double median_disparity(const cv::Mat& mask, const cv::Mat& disparity, const Eigen::Vector2d& at_px,
                        int half_px) {
  const cv::Point centre(static_cast<int>(std::lround(at_px.x())), static_cast<int>(std::lround(at_px.y())));
  const cv::Rect window(centre.x - half_px, centre.y - half_px, 2 * half_px + 1, 2 * half_px + 1);
  return median_in(window & cv::Rect({0, 0}, mask.size()), mask, disparity);
}

double median_disparity(const cv::Mat& mask, const cv::Mat& disparity) {
  return median_in(cv::boundingRect(mask), mask, disparity);
}

}  // namespace graspctx::detail
