// Photographs and renderings of one object before a plain background, as in the database of Saxena et al.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "detail/check.hpp"
#include "detail/quantile.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx {

namespace {

using Lab = cv::Vec3f;  // L from 0 to 100

cv::Mat lab_of(const cv::Mat& image) {
  cv::Mat colour, lab;
  cv::medianBlur(image, colour, 3);  // takes noise, but no edges
  if (colour.channels() == 1) cv::cvtColor(colour, colour, cv::COLOR_GRAY2BGR);
  colour.convertTo(colour, CV_32F, 1 / 255.0);
  cv::cvtColor(colour, lab, cv::COLOR_BGR2Lab);
  return lab;
}

/// One channel of the background: a quadratic surface over the image, since light falls off, and the spread
/// of the border's pixels around it.
struct BackgroundChannel {
  Eigen::Matrix<double, 6, 1> surface = Eigen::Matrix<double, 6, 1>::Zero();
  double sigma = 0;
};

Eigen::Matrix<double, 6, 1> surface_terms(const cv::Point& pixel, const cv::Size& size) {
  const double x = 2.0 * pixel.x / size.width - 1, y = 2.0 * pixel.y / size.height - 1;
  return (Eigen::Matrix<double, 6, 1>() << 1, x, y, x * x, x * y, y * y).finished();
}

/// Fit to the border's pixels; what an object puts there is dropped as outliers, from the median outwards.
BackgroundChannel fit_background(const cv::Mat& lab, int channel, const std::vector<cv::Point>& border) {
  const double robust_sigma = 1.4826;  // of a median absolute deviation
  std::vector<double> values, residuals(border.size());
  for (const cv::Point& pixel : border) values.push_back(lab.at<Lab>(pixel)[channel]);
  BackgroundChannel background;
  background.surface[0] = detail::median(values);
  for (int round = 0; round < 6; ++round) {
    for (std::size_t i = 0; i < border.size(); ++i) {
      residuals[i] = std::abs(values[i] - background.surface.dot(surface_terms(border[i], lab.size())));
    }
    background.sigma = robust_sigma * detail::median(residuals);
    const double limit = 3 * std::max(background.sigma, 0.3);
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Identity() * 1e-6;
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t i = 0; i < border.size(); ++i) {
      if (residuals[i] > limit) continue;
      const Eigen::Matrix<double, 6, 1> terms = surface_terms(border[i], lab.size());
      normal += terms * terms.transpose();
      right += terms * values[i];
    }
    background.surface = normal.ldlt().solve(right);
  }
  return background;
}

enum Likeness : uchar { unlike, shadow, alike };

struct Comparison {
  cv::Mat likeness;     // CV_8UC1, Likeness: what the pixel could be
  cv::Mat distance;     // CV_32FC1, of its colour from the background's
  cv::Mat light_share;  // CV_32FC1, its lightness over the background's
};

/// Each pixel's colour against the background's at that place.
Comparison compare_with_background(const cv::Mat& lab, const std::vector<cv::Point>& border) {
  BackgroundChannel background[3];
  for (int channel = 0; channel < 3; ++channel) background[channel] = fit_background(lab, channel, border);
  const double sigma_l = std::max(background[0].sigma, 0.7);
  const double sigma_ab = std::max({background[1].sigma, background[2].sigma, 0.5});
  const double same_l = 4 * sigma_l + 2, same_ab = 4 * sigma_ab + 1.5;
  const double deepest_shadow = 0.5;  // of the background's lightness
  Comparison result{cv::Mat(lab.size(), CV_8UC1), cv::Mat(lab.size(), CV_32FC1),
                    cv::Mat(lab.size(), CV_32FC1)};
  for (int v = 0; v < lab.rows; ++v) {
    for (int u = 0; u < lab.cols; ++u) {
      const Lab& colour = lab.at<Lab>(v, u);
      const Eigen::Matrix<double, 6, 1> terms = surface_terms({u, v}, lab.size());
      const double expected_l = std::max(1.0, background[0].surface.dot(terms));
      const double below = expected_l - colour[0];
      const double colour_apart = std::hypot(colour[1] - background[1].surface.dot(terms),
                                             colour[2] - background[2].surface.dot(terms));
      // A shadow takes lightness, and little of a pale background's colour.
      const bool has_colour = colour_apart < same_ab + 0.05 * std::max(0.0, below);
      const bool is_shadow = has_colour && below > 0 && colour[0] > deepest_shadow * expected_l;
      const bool is_alike = colour_apart < same_ab && std::abs(below) < same_l;
      result.likeness.at<uchar>(v, u) = is_alike ? alike : is_shadow ? shadow : unlike;
      result.distance.at<float>(v, u) = static_cast<float>(std::hypot(below, colour_apart));
      result.light_share.at<float>(v, u) = static_cast<float>(colour[0] / expected_l);
    }
  }
  return result;
}

cv::Mat disc(int radius_px) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius_px + 1, 2 * radius_px + 1});
}

/// Steps of lightness between neighbours that are too steep for the penumbra of a shadow.
cv::Mat sharp_edges(const cv::Mat& lab) {
  const double steep = 5;  // of 100, from a pixel to the next but one
  cv::Mat lightness, du, dv, slope;
  cv::extractChannel(lab, lightness, 0);
  cv::GaussianBlur(lightness, lightness, {5, 5}, 1);
  cv::Sobel(lightness, du, CV_32F, 1, 0, 3, 0.25);
  cv::Sobel(lightness, dv, CV_32F, 0, 1, 3, 0.25);
  cv::magnitude(du, dv, slope);
  return slope > steep;
}

/// The pixels of `passable` that are connected with the border.
cv::Mat reached_from_border(const cv::Mat& passable) {
  cv::Mat components, reached = cv::Mat::zeros(passable.size(), CV_8UC1);
  const int count = cv::connectedComponents(passable, components, 4);
  std::vector<char> at_border(static_cast<std::size_t>(count), 0);
  for (int v = 0; v < passable.rows; ++v) {
    const bool is_edge_row = v == 0 || v == passable.rows - 1;
    for (int u = 0; u < passable.cols; u += is_edge_row ? 1 : std::max(1, passable.cols - 1)) {
      at_border[static_cast<std::size_t>(components.at<int>(v, u))] = 1;
    }
  }
  at_border[0] = 0;
  for (int v = 0; v < passable.rows; ++v) {
    for (int u = 0; u < passable.cols; ++u) {
      if (at_border[static_cast<std::size_t>(components.at<int>(v, u))] != 0) reached.at<uchar>(v, u) = 255;
    }
  }
  return reached;
}

/// Where the background shows through an object. Smaller spots of its colour are highlights; what is in
/// shadow all over may be the object's own inside, and stays.
cv::Mat holes(const cv::Mat& object, const cv::Mat& passable, const cv::Mat& likeness) {
  const double least_alike = 0.15;
  const int least_px = std::max(20, cv::countNonZero(object) / 200);
  cv::Mat components, statistics, centroids, result = cv::Mat::zeros(object.size(), CV_8UC1);
  const int count = cv::connectedComponentsWithStats(object & passable, components, statistics, centroids, 4);
  for (int i = 1; i < count; ++i) {
    const int area_px = statistics.at<int>(i, cv::CC_STAT_AREA);
    if (area_px < least_px) continue;
    const cv::Mat component = components == i;
    if (cv::countNonZero(component & (likeness == alike)) >= least_alike * area_px) {
      result.setTo(255, component);
    }
  }
  return result;
}

/// A shadow with a sharp edge: it takes the same share of the light everywhere, and there is an object of
/// another colour to cast it. (A grey object is shaded, or stands alone.)
cv::Mat hard_shadows(const cv::Mat& object, const Comparison& compared) {
  const double least_caster = 0.2, same_share = 0.03, least_share = 0.02, least_outside = 0.3;
  const int object_px = cv::countNonZero(object);
  cv::Mat result = cv::Mat::zeros(object.size(), CV_8UC1);
  if (cv::countNonZero(object & (compared.likeness == unlike)) < least_caster * object_px) return result;
  cv::Mat candidates = object & (compared.likeness == shadow), components, statistics, centroids;
  const int count = cv::connectedComponentsWithStats(candidates, components, statistics, centroids, 4);
  for (int i = 1; i < count; ++i) {
    if (statistics.at<int>(i, cv::CC_STAT_AREA) < std::max(20.0, least_share * object_px)) continue;
    const cv::Rect box(statistics.at<int>(i, cv::CC_STAT_LEFT), statistics.at<int>(i, cv::CC_STAT_TOP),
                       statistics.at<int>(i, cv::CC_STAT_WIDTH), statistics.at<int>(i, cv::CC_STAT_HEIGHT));
    // A shadow lies beside the object: the inside of a mug is surrounded by it.
    cv::Mat ring;
    const cv::Mat whole = components == i;
    cv::dilate(whole, ring, disc(1));
    ring &= ~whole;
    if (cv::countNonZero(ring & ~object) < least_outside * cv::countNonZero(ring)) continue;
    const cv::Mat component = whole(box), share = compared.light_share(box);
    std::vector<double> shares, deviations;
    for (int v = 0; v < box.height; ++v) {
      for (int u = 0; u < box.width; ++u) {
        if (component.at<uchar>(v, u) != 0) shares.push_back(share.at<float>(v, u));
      }
    }
    const double middle = detail::median(shares);
    for (const double value : shares) deviations.push_back(std::abs(value - middle));
    if (detail::median(deviations) < same_share) result(box).setTo(255, component);
  }
  return result;
}

/// The pixels along an edge are a mixture: the outer ones, nearer to the background's colour than to the
/// object's just inside, are taken off.
cv::Mat without_mixed_edge(const cv::Mat& object, const cv::Mat& distance) {
  const int mixed_px = 4;
  cv::Mat inside_distance, strongest, result = object.clone();
  distance.copyTo(inside_distance, object);
  cv::dilate(inside_distance, strongest, disc(mixed_px));
  const cv::Mat is_mixed = distance < 0.5 * strongest;
  for (int round = 0; round < mixed_px; ++round) {
    cv::Mat inner;
    cv::erode(result, inner, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
    result &= inner | ~is_mixed;
  }
  return result;
}

/// The largest component and those not much smaller; away from the border if there are such.
cv::Mat main_components(const cv::Mat& mask) {
  const double not_much_smaller = 0.2;
  cv::Mat components, statistics, centroids, kept = cv::Mat::zeros(mask.size(), CV_8UC1);
  const int count = cv::connectedComponentsWithStats(mask, components, statistics, centroids, 8);
  for (const bool may_touch_border : {false, true}) {
    const auto area_of = [&](int i) {
      const int left = statistics.at<int>(i, cv::CC_STAT_LEFT), top = statistics.at<int>(i, cv::CC_STAT_TOP);
      const bool touches = left == 0 || top == 0 ||
                           left + statistics.at<int>(i, cv::CC_STAT_WIDTH) == mask.cols ||
                           top + statistics.at<int>(i, cv::CC_STAT_HEIGHT) == mask.rows;
      return touches && !may_touch_border ? 0 : statistics.at<int>(i, cv::CC_STAT_AREA);
    };
    int largest_px = 0;
    for (int i = 1; i < count; ++i) largest_px = std::max(largest_px, area_of(i));
    if (largest_px == 0) continue;
    for (int i = 1; i < count; ++i) {
      if (area_of(i) >= not_much_smaller * largest_px) kept.setTo(255, components == i);
    }
    return kept;
  }
  return kept;
}

}  // namespace

cv::Mat plain_background_mask(const cv::Mat& image) {
  detail::require_image(image, "image");
  const int frame_px = std::max(3, std::min(image.rows, image.cols) / 50);
  if (std::min(image.rows, image.cols) < 8 * frame_px) {
    throw InvalidInput("image: expected at least 24 px a side, got " + detail::describe(image));
  }
  std::vector<cv::Point> border;
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const int from_edge = std::min({u, v, image.cols - 1 - u, image.rows - 1 - v});
      if (from_edge < frame_px) border.emplace_back(u, v);
    }
  }
  const cv::Mat lab = lab_of(image);
  const Comparison compared = compare_with_background(lab, border);

  // The background grows in from the border through its own colour, and through shadows as far as no sharp
  // edge stands in the way: a grey object has the colour of a shadow, but not its penumbra. It does not pass
  // gaps of a few pixels, such as a rim leaves between the background and a grey inside.
  const cv::Mat passable = (compared.likeness == alike) | ((compared.likeness == shadow) & ~sharp_edges(lab));
  cv::Mat wide, background;
  cv::erode(passable, wide, disc(2));
  cv::dilate(reached_from_border(wide), background, disc(2));
  background &= passable;
  cv::Mat object = main_components(~background);
  object &= ~hard_shadows(object, compared);
  object &= ~holes(object, passable, compared.likeness);
  object = without_mixed_edge(object, compared.distance);
  cv::morphologyEx(object, object, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
  object = main_components(object);
  return object;
}

}  // namespace graspctx
