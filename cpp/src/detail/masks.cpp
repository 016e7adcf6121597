#include "detail/masks.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace graspctx::detail {

namespace {

/// How many pixels of another mask each connected part of a mask holds; 0 for what is no part.
struct Parts {
  cv::Mat labels;  // CV_32SC1
  std::vector<int> held;

  Parts(const cv::Mat& mask, const cv::Mat& other) {
    held.resize(static_cast<std::size_t>(cv::connectedComponents(mask, labels, 8, CV_32S)), 0);
    for (int v = 0; v < mask.rows; ++v) {
      for (int u = 0; u < mask.cols; ++u) {
        if (other.at<uchar>(v, u)) ++held[static_cast<std::size_t>(labels.at<int>(v, u))];
      }
    }
    held[0] = 0;
  }
  cv::Mat with_at_least(int least) const {
    cv::Mat kept(labels.size(), CV_8UC1);
    for (int v = 0; v < kept.rows; ++v) {
      for (int u = 0; u < kept.cols; ++u) {
        kept.at<uchar>(v, u) = held[static_cast<std::size_t>(labels.at<int>(v, u))] >= least ? 255 : 0;
      }
    }
    return kept;
  }
};

}  // namespace

cv::Mat grown(const cv::Mat& mask, int by_px) {
  cv::Mat result;
  cv::dilate(mask, result, cv::Mat::ones(2 * by_px + 1, 2 * by_px + 1, CV_8U));
  return result;
}

cv::Mat shrunk(const cv::Mat& mask, int by_px) {
  cv::Mat result;
  cv::erode(mask, result, cv::Mat::ones(2 * by_px + 1, 2 * by_px + 1, CV_8U));
  return result;
}

cv::Mat convex_hull(const cv::Mat& mask) {
  std::vector<cv::Point> points, hull;
  cv::findNonZero(mask, points);
  cv::convexHull(points, hull);
  cv::Mat filled = cv::Mat::zeros(mask.size(), CV_8UC1);
  cv::fillConvexPoly(filled, hull, 255);
  return filled;
}

std::vector<cv::Point> where(const cv::Mat& mask) {
  std::vector<cv::Point> points;
  cv::findNonZero(mask, points);
  return points;
}

cv::Mat parts_holding(const cv::Mat& mask, const cv::Mat& other, int least) {
  return Parts(mask, other).with_at_least(std::max(least, 1));
}

cv::Mat parts_with_seeds(const cv::Mat& mask, const cv::Mat& seeds) {
  const Parts parts(mask, seeds);
  const int most = *std::max_element(parts.held.begin(), parts.held.end());
  return parts.with_at_least(most / 5 + 1);
}

}  // namespace graspctx::detail
