#include "detail/table_evidence.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "detail/plane_geometry.hpp"

namespace graspctx::detail {

namespace {

constexpr float largest_misfit = 9;
constexpr int reach_px = 40;  // farther from every seed, nothing is asked

/// Squared colour difference of a left pixel and the right row at a fraction of a pixel, in units of its
/// variance: the noise of both, and what a quarter of a pixel of wrong disparity makes of the gradient.
class Misfit {
 public:
  Misfit(const Relief& relief, int v)
      : left_(relief.left.ptr<float>(v)),
        right_(relief.right.ptr<float>(v)),
        channels_(relief.left.channels()) {
    constexpr double least_noise = 1.5;
    const double noise = std::max(relief.noise, least_noise);
    noise_variance_ = static_cast<float>(4 * noise * noise);
  }
  float operator()(int u, double right_u) const {
    constexpr float gradient_share = 0.125F;
    const int whole = static_cast<int>(right_u);
    const auto part = static_cast<float>(right_u - whole);
    float sum = 0;
    for (int c = 0; c < channels_; ++c) {
      const float here = right_[whole * channels_ + c];
      const float gradient = right_[(whole + 1) * channels_ + c] - here;
      const float difference = left_[u * channels_ + c] - (here + part * gradient);
      sum += difference * difference / (noise_variance_ + gradient_share * gradient * gradient);
    }
    return std::min(3 * sum / static_cast<float>(channels_), largest_misfit);
  }

 private:
  const float *left_, *right_;
  int channels_;
  float noise_variance_;
};

}  // namespace

cv::Mat misfit_of_table(const Relief& relief, const TablePlane& plane) {
  cv::Mat result(relief.left.size(), CV_32FC1, cv::Scalar(-1));
  const double last = result.cols - 1.001;
  for (int v = 0; v < result.rows; ++v) {
    const Misfit misfit(relief, v);
    for (int u = 0; u < result.cols; ++u) {
      const double as_table = u - plane_disparity(plane, u, v);
      if (as_table >= 0 && as_table <= last) result.at<float>(v, u) = misfit(u, as_table);
    }
  }
  return result;
}

cv::Mat odds_of_table(const Relief& relief, const TablePlane& plane, const cv::Mat& seeds) {
  const cv::Size size = seeds.size();
  cv::Mat odds = cv::Mat::zeros(size, CV_32FC1);
  cv::Rect box = cv::boundingRect(seeds);
  if (box.empty()) return odds;
  box = cv::Rect(box.x - reach_px, box.y - reach_px, box.width + 2 * reach_px, box.height + 2 * reach_px) &
        cv::Rect({0, 0}, size);
  cv::Mat away_px, nearest;
  cv::distanceTransform(~seeds(box), away_px, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<float> residual_of(box.area() + std::size_t{1}, 0);
  for (int v = 0; v < box.height; ++v) {
    for (int u = 0; u < box.width; ++u) {
      const cv::Point at(box.x + u, box.y + v);
      if (seeds.at<uchar>(at)) {
        residual_of[static_cast<std::size_t>(nearest.at<int>(v, u))] = relief.residual_px.at<float>(at);
      }
    }
  }
  cv::Mat better_as_object = cv::Mat::zeros(box.size(), CV_32FC1);
  cv::Mat misfit_as_object(box.size(), CV_32FC1, cv::Scalar(largest_misfit));
  const double last = size.width - 1.001;
  for (int v = 0; v < box.height; ++v) {
    const Misfit misfit(relief, box.y + v);
    for (int u = 0; u < box.width; ++u) {
      if (away_px.at<float>(v, u) > reach_px) continue;
      const int left_u = box.x + u;
      const double as_table = left_u - plane_disparity(plane, left_u, box.y + v);
      const double as_object = as_table - residual_of[static_cast<std::size_t>(nearest.at<int>(v, u))];
      // Written so that a residual that is not a number fails too.
      if (!(as_object >= 0 && as_object <= last && as_table >= 0 && as_table <= last)) continue;
      misfit_as_object.at<float>(v, u) = misfit(left_u, as_object);
      better_as_object.at<float>(v, u) = misfit(left_u, as_table) - misfit_as_object.at<float>(v, u);
    }
  }
  cv::boxFilter(better_as_object, better_as_object, CV_32F, {3, 3});
  cv::boxFilter(misfit_as_object, misfit_as_object, CV_32F, {3, 3});
  // For the object only its own pixels speak, and only where its disparity fits to the noise: the gap of a
  // handle is hidden from the right view, and fits neither.
  constexpr double fits = 1, surest_of_table = -3, surest_of_object = 6;
  const cv::Mat fits_object = seeds(box) & (misfit_as_object < fits);
  const cv::Mat of_table = cv::max(cv::min(better_as_object, 0.0), surest_of_table);
  of_table.copyTo(odds(box));
  const cv::Mat of_object = cv::min(better_as_object, surest_of_object);
  of_object.copyTo(odds(box), fits_object & (better_as_object > 0));
  return odds;
}

}  // namespace graspctx::detail
