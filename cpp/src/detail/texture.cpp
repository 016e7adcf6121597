#include "detail/texture.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace graspctx::detail {

cv::Mat grey(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat converted;
  cv::cvtColor(image, converted, cv::COLOR_BGR2GRAY);
  return converted;
}

double noise_sigma(const cv::Mat& grey_image) {
  // A mask that answers neither to slopes nor to edges along the axes; scaled to keep white noise's sigma.
  const cv::Matx33f mask(1, -2, 1, -2, 4, -2, 1, -2, 1);
  cv::Mat response;
  cv::filter2D(grey_image, response, CV_32F, mask * (1.0F / 6), {-1, -1}, 0, cv::BORDER_REFLECT_101);

  // The quietest fifth of the blocks shows the noise, the others texture. Saturated blocks show neither.
  constexpr int block_px = 16;
  std::vector<double> sigmas;
  for (int y = 0; y + block_px <= grey_image.rows; y += block_px) {
    for (int x = 0; x + block_px <= grey_image.cols; x += block_px) {
      const cv::Rect block(x, y, block_px, block_px);
      const double mean = cv::mean(grey_image(block))[0];
      if (mean < 4 || mean > 251) continue;
      sigmas.push_back(std::sqrt(cv::norm(response(block), cv::NORM_L2SQR) / block.area()));
    }
  }
  const double rounding = 1 / std::sqrt(12.0);
  if (sigmas.empty()) return rounding;
  const auto quiet = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 5);
  std::nth_element(sigmas.begin(), quiet, sigmas.end());
  return std::max(rounding, *quiet);
}

cv::Mat horizontal_texture(const cv::Mat& grey_image, double sigmas) {
  cv::Mat gradient, energy;
  const cv::Matx13f central_difference(-0.5F, 0, 0.5F);
  cv::filter2D(grey_image, gradient, CV_32F, central_difference, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::sqrBoxFilter(gradient, energy, CV_32F, {7, 7}, {-1, -1}, true, cv::BORDER_REPLICATE);
  const double sigma = noise_sigma(grey_image);
  const double noise_energy = sigma * sigma / 2;  // of the central difference
  return energy >= sigmas * sigmas * noise_energy;
}

}  // namespace graspctx::detail
