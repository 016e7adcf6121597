#include "detail/figure_ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

namespace graspctx::detail {

namespace {

constexpr int hue_bins = 12, saturation_bins = 12, grey_bins = 12;
constexpr int colour_bins = hue_bins * saturation_bins + grey_bins;
using Histogram = std::array<float, colour_bins>;

/// The colour bin of each pixel, CV_16UC1: hue and saturation, or grey where there is hardly any colour.
cv::Mat colour_indices(const cv::Mat& image) {
  cv::Mat indices(image.size(), CV_16UC1);
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, {3, 3}, 0);
  if (image.channels() == 1) {
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        indices.at<ushort>(v, u) =
            static_cast<ushort>(hue_bins * saturation_bins + smooth.at<uchar>(v, u) * grey_bins / 256);
      }
    }
    return indices;
  }
  cv::Mat hsv;
  cv::cvtColor(smooth, hsv, cv::COLOR_BGR2HSV_FULL);
  constexpr int least_chroma = 20;  // saturation · value: below, hue is noise
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const auto& pixel = hsv.at<cv::Vec3b>(v, u);
      const int chroma = pixel[1] * pixel[2] / 255;
      const int index = chroma < least_chroma ? hue_bins * saturation_bins + pixel[2] * grey_bins / 256
                                              : (pixel[0] * hue_bins / 256) * saturation_bins +
                                                    pixel[1] * saturation_bins / 256;
      indices.at<ushort>(v, u) = static_cast<ushort>(index);
    }
  }
  return indices;
}

Histogram histogram(const cv::Mat& indices, const cv::Mat& mask) {
  Histogram bins;
  bins.fill(1.0F);  // a colour never seen is unlikely, not impossible
  float sum = colour_bins;
  for (int v = 0; v < indices.rows; ++v) {
    for (int u = 0; u < indices.cols; ++u) {
      if (!mask.at<uchar>(v, u)) continue;
      ++bins[indices.at<ushort>(v, u)];
      ++sum;
    }
  }
  for (float& bin : bins) bin /= sum;
  return bins;
}

double squared_difference(const cv::Mat& image, const cv::Point& a, const cv::Point& b) {
  if (image.channels() == 1) {
    const double d = double(image.at<uchar>(a)) - image.at<uchar>(b);
    return 3 * d * d;
  }
  const cv::Vec3d d = cv::Vec3d(image.at<cv::Vec3b>(a)) - cv::Vec3d(image.at<cv::Vec3b>(b));
  return d.dot(d);
}

}  // namespace

cv::Mat cut_figure(const FigureEvidence& evidence) {
  const cv::Mat& image = evidence.image;
  const int width = image.cols, height = image.rows;
  const cv::Mat indices = colour_indices(image);
  const Histogram figure = histogram(indices, evidence.figure_seeds);
  const Histogram ground = histogram(indices, evidence.ground_seeds);

  const std::array<cv::Point, 4> neighbours{{{1, 0}, {0, 1}, {1, 1}, {-1, 1}}};
  const cv::Rect inside(0, 0, width, height);
  double sum = 0, pairs = 0;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u + 1 < width; ++u) {
      sum += squared_difference(image, {u, v}, {u + 1, v});
      ++pairs;
    }
  }
  const double contrast = 1 / (2 * std::max(sum / std::max(pairs, 1.0), 1.0));

  constexpr double colour_weight = 0.7;  // neighbouring pixels' colours are not independent
  constexpr double largest_colour_odds = 3;
  constexpr double smoothness = 6;
  cv::detail::GCGraph<double> graph(static_cast<unsigned>(width * height),
                                    static_cast<unsigned>(4 * width * height));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int vertex = graph.addVtx();
      const auto index = indices.at<ushort>(v, u);
      const double colour = std::clamp(colour_weight * std::log(figure[index] / ground[index]),
                                       -largest_colour_odds, largest_colour_odds);
      const double odds = evidence.log_odds.at<float>(v, u) + colour;
      graph.addTermWeights(vertex, std::max(odds, 0.0), std::max(-odds, 0.0));
    }
  }
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      for (const cv::Point& step : neighbours) {
        const cv::Point here(u, v), there = here + step;
        if (!inside.contains(there)) continue;
        const double weight = smoothness * std::exp(-contrast * squared_difference(image, here, there)) /
                              std::sqrt(double(step.dot(step)));
        graph.addEdges(v * width + u, there.y * width + there.x, weight, weight);
      }
    }
  }
  graph.maxFlow();
  cv::Mat mask(image.size(), CV_8UC1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) mask.at<uchar>(v, u) = graph.inSourceSegment(v * width + u) ? 255 : 0;
  }
  return mask;
}

}  // namespace graspctx::detail
