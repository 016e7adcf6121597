#include "graspctx/fovea.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "detail/check.hpp"
#include "detail/quantile.hpp"
#include "detail/refined_mask.hpp"

namespace graspctx {

namespace {

/// Re-sample an image: view_px = scale · (image_px − origin_px).
cv::Mat resample(const cv::Mat& image, double scale, const Eigen::Vector2d& origin_px,
                 const cv::Size& view_size, int interpolation) {
  cv::Mat source;
  if (scale < 1 && interpolation != cv::INTER_NEAREST) {
    // Remove what the smaller view cannot carry; the view of a near object is as sharp as that of a far one.
    const double sigma = 0.5 * std::sqrt(1 / (scale * scale) - 1);
    cv::GaussianBlur(image, source, cv::Size(), sigma, sigma, cv::BORDER_REPLICATE);
  } else {
    source = image;
  }
  const cv::Matx23d view_from_image(scale, 0, -scale * origin_px.x(), 0, scale, -scale * origin_px.y());
  const int border = interpolation == cv::INTER_NEAREST ? cv::BORDER_CONSTANT : cv::BORDER_REPLICATE;
  cv::Mat view;
  cv::warpAffine(source, view, view_from_image, view_size, interpolation, border);
  return view;
}

FovealView view_at(const cv::Mat& image, const cv::Mat& mask, double scale, const Eigen::Vector2d& origin_px,
                   const cv::Size& view_size) {
  FovealView view;
  view.scale = scale;
  view.origin_px = origin_px;
  view.image = resample(image, scale, origin_px, view_size, cv::INTER_LINEAR);
  view.mask = resample(mask > 0, scale, origin_px, view_size, cv::INTER_NEAREST);
  return view;
}

/// What the mask means in this image: the mask as it is, or refined.
cv::Mat figure_of(const cv::Mat& image, const cv::Mat& mask, const FoveaOptions& options) {
  options.check();
  detail::require_image(image, "image");
  detail::require_mask(mask, image.size(), "object mask");
  if (cv::countNonZero(mask) == 0) {
    throw InvalidInput("object mask: it is empty, expected at least one pixel > 0");
  }
  return options.refine_mask ? detail::refined_mask(image, mask) : mask;
}

FovealView view_of_figure(const cv::Mat& image, const cv::Mat& figure, const FoveaOptions& options) {
  const cv::Rect box = cv::boundingRect(figure);
  const double scale = static_cast<double>(options.object_px) / std::max(box.width, box.height);
  const Eigen::Vector2d origin_px(box.x - options.margin_px / scale, box.y - options.margin_px / scale);
  const cv::Size size(static_cast<int>(std::ceil(box.width * scale)) + 2 * options.margin_px,
                      static_cast<int>(std::ceil(box.height * scale)) + 2 * options.margin_px);
  return view_at(image, figure, scale, origin_px, size);
}

}  // namespace

void FoveaOptions::check() const {
  detail::require_option(object_px >= 20 && object_px <= 4000, "fovea object_px must be 20 to 4000");
  detail::require_option(margin_px >= 0 && margin_px <= 1000, "fovea margin_px must be 0 to 1000");
}

FovealView foveal_view(const cv::Mat& image, const cv::Mat& mask, const FoveaOptions& options) {
  return view_of_figure(image, figure_of(image, mask, options), options);
}

std::optional<FovealPair> foveal_pair(const RectifiedPair& pair, const cv::Mat& object_mask,
                                      const cv::Mat& disparity, const FoveaOptions& options) {
  const cv::Mat mask = figure_of(pair.left, object_mask, options);
  FovealPair fovea;
  fovea.left = view_of_figure(pair.left, mask, options);
  detail::require_image(pair.right, "right image");
  if (disparity.type() != CV_32FC1 || disparity.size() != mask.size()) {
    throw InvalidInput("disparity: expected CV_32FC1 of the image's size, got " +
                       detail::describe(disparity));
  }

  std::vector<float> object_disparities;
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      if (mask.at<uchar>(v, u) && std::isfinite(disparity.at<float>(v, u))) {
        object_disparities.push_back(disparity.at<float>(v, u));
      }
    }
  }
  if (object_disparities.empty()) return std::nullopt;
  const double low = detail::quantile(object_disparities, 0.05),
               high = detail::quantile(object_disparities, 0.95);
  const double median = detail::quantile(object_disparities, 0.5);

  // Carry the mask over to the right view. Pixels without a plausible disparity move with the median.
  cv::Mat right_mask = cv::Mat::zeros(mask.size(), CV_8UC1);
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      if (!mask.at<uchar>(v, u)) continue;
      const double d = disparity.at<float>(v, u);
      const bool plausible = std::isfinite(d) && d >= low && d <= high;
      const int right_u = static_cast<int>(std::lround(u - (plausible ? d : median)));
      if (right_u >= 0 && right_u < mask.cols) right_mask.at<uchar>(v, right_u) = 255;
    }
  }
  cv::morphologyEx(right_mask, right_mask, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_RECT, {5, 1}));

  fovea.fixation_disparity_px = median;
  const Eigen::Vector2d right_origin_px = fovea.left.origin_px - Eigen::Vector2d(median, 0);
  fovea.right = view_at(pair.right, right_mask, fovea.left.scale, right_origin_px, fovea.left.image.size());
  return fovea;
}

}  // namespace graspctx
