#include "detail/plain_table.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "detail/masks.hpp"
#include "detail/quantile.hpp"
#include "detail/texture.hpp"

namespace graspctx::detail {

namespace {

constexpr int channels = 3;
constexpr double blur_px = 1.5;  // at half resolution
using Surface = Eigen::Matrix<double, 6, 1>;

/// The image at half resolution, smoothed: what is plain shows there with little noise.
struct SmoothView {
  cv::Mat colour;                              // CV_32FC3
  std::array<double, channels> image_noise{};  // of a pixel of the full image, grey levels
  std::array<double, channels> noise{};        // of a pixel of this view

  explicit SmoothView(const cv::Mat& image) {
    std::array<cv::Mat, channels> planes;
    cv::split(image, planes.data());
    // Each pixel here is the mean of four, then of a Gaussian's 4·pi·sigma².
    const double averaged = 2 * 2 * std::sqrt(CV_PI) * blur_px;
    constexpr double rounding = 0.25;  // steps of a grey level show where noise does not break them
    for (std::size_t c = 0; c < channels; ++c) {
      image_noise[c] = noise_sigma(planes[c]);
      noise[c] = std::max(rounding, image_noise[c] / averaged);
    }
    cv::resize(image, colour, {(image.cols + 1) / 2, (image.rows + 1) / 2}, 0, 0, cv::INTER_AREA);
    colour.convertTo(colour, CV_32F);
    cv::GaussianBlur(colour, colour, {0, 0}, blur_px);
  }
};

/// Where the colour changes no more than noise and slow shading make it change.
cv::Mat flat_pixels(const SmoothView& view) {
  constexpr int reach_px = 2;
  constexpr double most_sigmas = 5, most_levels = 1.2;
  cv::Mat flat = cv::Mat::zeros(view.colour.size(), CV_8UC1);
  for (int v = reach_px; v < flat.rows - reach_px; ++v) {
    const auto* above = view.colour.ptr<cv::Vec3f>(v - reach_px);
    const auto* here = view.colour.ptr<cv::Vec3f>(v);
    const auto* under = view.colour.ptr<cv::Vec3f>(v + reach_px);
    for (int u = reach_px; u < flat.cols - reach_px; ++u) {
      bool is_flat = true;
      for (int c = 0; c < channels; ++c) {
        const double limit = std::max(most_levels, std::sqrt(2.0) * most_sigmas * view.noise[std::size_t(c)]);
        const double du = here[u + reach_px][c] - here[u - reach_px][c], dv = under[u][c] - above[u][c];
        is_flat = is_flat && du * du + dv * dv < limit * limit;
      }
      flat.at<uchar>(v, u) = is_flat ? 255 : 0;
    }
  }
  // The windows did not fit along the sides: as flat as their neighbours.
  const cv::Rect inner(reach_px, reach_px, flat.cols - 2 * reach_px, flat.rows - 2 * reach_px);
  cv::copyMakeBorder(flat(inner).clone(), flat, reach_px, reach_px, reach_px, reach_px, cv::BORDER_REPLICATE);
  return shrunk(flat, 1);
}

Surface surface_terms(const cv::Point& pixel, const cv::Size& size) {
  const double x = 2.0 * pixel.x / size.width - 1, y = 2.0 * pixel.y / size.height - 1;
  return (Surface() << 1, x, y, x * x, x * y, y * y).finished();
}

/// About `wanted` of the pixels in a mask, evenly.
std::vector<cv::Point> some_of(const cv::Mat& mask, std::size_t wanted) {
  std::vector<cv::Point> pixels = where(mask);
  const std::size_t step = std::max<std::size_t>(1, pixels.size() / wanted);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < pixels.size(); i += step) pixels[kept++] = pixels[i];
  pixels.resize(kept);
  return pixels;
}

/// A quadratic surface for each channel through the colours in a mask, outliers left out.
std::array<Surface, channels> fit_surfaces(const cv::Mat& colour, const cv::Mat& mask,
                                           const std::array<double, channels>& least_sigma) {
  const std::vector<cv::Point> pixels = some_of(mask, 2000);
  std::vector<char> used(pixels.size(), 1);
  std::array<Surface, channels> surfaces;
  for (int round = 0; round < 5; ++round) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Identity() * 1e-6;
    Eigen::Matrix<double, 6, channels> right = Eigen::Matrix<double, 6, channels>::Zero();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (!used[i]) continue;
      const Surface terms = surface_terms(pixels[i], mask.size());
      normal += terms * terms.transpose();
      for (int c = 0; c < channels; ++c) right.col(c) += terms * colour.at<cv::Vec3f>(pixels[i])[c];
    }
    const Eigen::Matrix<double, 6, channels> solved = normal.ldlt().solve(right);
    for (int c = 0; c < channels; ++c) surfaces[std::size_t(c)] = solved.col(c);
    std::fill(used.begin(), used.end(), char(1));
    for (std::size_t c = 0; c < channels; ++c) {
      std::vector<double> apart;
      for (const cv::Point& pixel : pixels) {
        apart.push_back(std::abs(colour.at<cv::Vec3f>(pixel)[int(c)] -
                                 surfaces[c].dot(surface_terms(pixel, mask.size()))));
      }
      const double limit = 3 * std::max(1.4826 * median(apart), least_sigma[c]);
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        if (apart[i] > limit) used[i] = 0;
      }
    }
  }
  return surfaces;
}

/// The colour a plain region would have everywhere: a quadratic surface, and what light does beyond that as
/// a smooth mean over the region.
cv::Mat expected_colour(const SmoothView& view, const cv::Mat& region) {
  const auto surfaces = fit_surfaces(view.colour, region, view.noise);
  const cv::Size size = region.size();
  cv::Mat expected(size, CV_32FC3), apart(size, CV_32FC3, cv::Scalar::all(0));
  cv::Mat weight(size, CV_32FC1, cv::Scalar(0));
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const Surface terms = surface_terms({u, v}, size);
      auto& value = expected.at<cv::Vec3f>(v, u);
      for (std::size_t c = 0; c < channels; ++c) value[int(c)] = static_cast<float>(surfaces[c].dot(terms));
      if (!region.at<uchar>(v, u)) continue;
      apart.at<cv::Vec3f>(v, u) = view.colour.at<cv::Vec3f>(v, u) - value;
      weight.at<float>(v, u) = 1;
    }
  }
  // Far from the region the surface alone stands.
  const int window = size.width / 10 | 1;
  constexpr float surface_weight = 0.02F;
  for (int pass = 0; pass < 2; ++pass) {
    cv::blur(apart, apart, {window, window}, {-1, -1}, cv::BORDER_ISOLATED | cv::BORDER_REFLECT_101);
    cv::blur(weight, weight, {window, window}, {-1, -1}, cv::BORDER_ISOLATED | cv::BORDER_REFLECT_101);
  }
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      expected.at<cv::Vec3f>(v, u) +=
          apart.at<cv::Vec3f>(v, u) * (1 / (weight.at<float>(v, u) + surface_weight));
    }
  }
  return expected;
}

/// Robust standard deviation of a region around its expected colour, by channel.
std::array<double, channels> spread(const cv::Mat& colour, const cv::Mat& expected, const cv::Mat& region,
                                    const std::array<double, channels>& least) {
  std::array<double, channels> sigma = least;
  const std::vector<cv::Point> pixels = some_of(region, 5000);
  if (pixels.empty()) return sigma;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<float> apart;
    for (const cv::Point& pixel : pixels) {
      apart.push_back(std::abs(colour.at<cv::Vec3f>(pixel)[int(c)] - expected.at<cv::Vec3f>(pixel)[int(c)]));
    }
    sigma[c] = std::max(least[c], 1.4826 * median(std::move(apart)));
  }
  return sigma;
}

/// The pixels of a region's colour that are connected with it.
cv::Mat same_colour(const cv::Mat& colour, const cv::Mat& expected, const cv::Mat& region,
                    const std::array<double, channels>& sigma) {
  // Where there is hardly any noise, shading goes in steps: of a few levels, if the image was brightened.
  constexpr double most_sigmas = 5, step_levels = 3;
  cv::Mat like(colour.size(), CV_8UC1);
  for (int v = 0; v < like.rows; ++v) {
    for (int u = 0; u < like.cols; ++u) {
      const cv::Vec3f apart = colour.at<cv::Vec3f>(v, u) - expected.at<cv::Vec3f>(v, u);
      bool is_like = true;
      for (std::size_t c = 0; c < channels; ++c) {
        is_like = is_like && std::abs(apart[int(c)]) < std::max(step_levels, most_sigmas * sigma[c]);
      }
      like.at<uchar>(v, u) = is_like ? 255 : 0;
    }
  }
  cv::morphologyEx(like, like, cv::MORPH_OPEN, cv::Mat::ones(3, 3, CV_8U));
  return parts_holding(like, region, cv::countNonZero(region) / 50);
}

/// The plain parts of the view, each CV_8UC1, at least a share of it large.
std::vector<cv::Mat> plain_parts(const cv::Mat& flat) {
  constexpr double least_share = 0.04;
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(flat, labels, stats, centres, 4, CV_32S);
  std::vector<cv::Mat> parts;
  for (int label = 1; label < count; ++label) {
    if (stats.at<int>(label, cv::CC_STAT_AREA) >= least_share * double(flat.total())) {
      parts.emplace_back(labels == label);
    }
  }
  return parts;
}

/// How much of the image a support fills; what is high in the image is rather a wall.
double support_score(const cv::Mat& region) {
  const cv::Moments moments = cv::moments(region, true);
  const double middle = moments.m01 / std::max(moments.m00, 1.0) / region.rows;
  return moments.m00 / double(region.total()) * std::clamp(2 * middle, 0.1, 1.0);
}

}  // namespace

std::optional<PlainTable> find_plain_table(const cv::Mat& image) {
  cv::Mat bgr = image;
  if (image.channels() == 1) cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  const SmoothView view(bgr);
  cv::Mat best;
  constexpr double least_score = 0.16;
  double best_score = least_score;
  for (const cv::Mat& part : plain_parts(flat_pixels(view))) {
    const double score = support_score(part);
    if (score > best_score) {
      best_score = score;
      best = part;
    }
  }
  if (best.empty()) return std::nullopt;

  cv::Mat region = best, expected;
  for (int round = 0; round < 2; ++round) {
    expected = expected_colour(view, region);
    region = same_colour(view.colour, expected, region, spread(view.colour, expected, region, view.noise));
  }
  PlainTable table;
  cv::resize(region, table.region, image.size(), 0, 0, cv::INTER_NEAREST);
  cv::resize(expected, table.colour, image.size(), 0, 0, cv::INTER_LINEAR);
  cv::Mat body;  // without threads that leak into a background of like colour
  cv::morphologyEx(table.region, body, cv::MORPH_OPEN, cv::Mat::ones(15, 15, CV_8U));
  if (cv::countNonZero(body) == 0) return std::nullopt;
  table.extent = convex_hull(body);
  const auto sigma = spread(view.colour, expected, region, view.noise);
  for (std::size_t c = 0; c < channels; ++c) {
    table.sigma[int(c)] = std::hypot(view.image_noise[c], sigma[c]);
  }
  return table;
}

cv::Mat plain_table_outline(const PlainTable& table, int within_px) {
  // Reflected, so that the image's sides are no outline.
  const int pad = within_px + 1;
  cv::Mat padded;
  cv::copyMakeBorder(table.region, padded, pad, pad, pad, pad, cv::BORDER_REPLICATE);
  const cv::Mat outline = grown(padded, within_px) & ~shrunk(padded, within_px);
  return outline(cv::Rect({pad, pad}, table.region.size())).clone();
}

}  // namespace graspctx::detail
