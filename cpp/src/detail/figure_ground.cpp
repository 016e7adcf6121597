#include "detail/figure_ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

#include "detail/colour_bins.hpp"

namespace graspctx::detail {

namespace {

using Histogram = std::array<float, colour_bins>;

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

/// A tenth of the ground may lie in the object's shadow: the same colours, darker.
void add_shadow(const cv::Mat& colours, const cv::Mat& ground, Histogram& bins) {
  constexpr float share = 0.1F;
  constexpr std::array<float, 4> brightness{0.3F, 0.45F, 0.6F, 0.75F};
  Histogram shadow;
  shadow.fill(0.0F);
  float sum = 0;
  for (int v = 0; v < colours.rows; v += 2) {
    for (int u = 0; u < colours.cols; u += 2) {
      if (!ground.at<uchar>(v, u)) continue;
      const auto& pixel = colours.at<cv::Vec3b>(v, u);
      for (const float part : brightness) {
        const auto bin = colour_bin(pixel[0], pixel[1], static_cast<int>(part * pixel[2]));
        ++shadow[static_cast<std::size_t>(bin)];
        ++sum;
      }
    }
  }
  if (sum == 0) return;
  for (std::size_t i = 0; i < bins.size(); ++i) bins[i] = (1 - share) * bins[i] + share * shadow[i] / sum;
}

/// log of P(figure) / P(ground) by colour, CV_32FC1.
cv::Mat colour_odds(const cv::Mat& indices, const Histogram& figure, const Histogram& ground) {
  constexpr float surest = 5;
  Histogram odds_of;
  for (std::size_t i = 0; i < odds_of.size(); ++i) {
    odds_of[i] = std::clamp(std::log(figure[i] / ground[i]), -surest, surest);
  }
  cv::Mat odds(indices.size(), CV_32FC1);
  for (int v = 0; v < odds.rows; ++v) {
    for (int u = 0; u < odds.cols; ++u) odds.at<float>(v, u) = odds_of[indices.at<ushort>(v, u)];
  }
  return odds;
}

/// What the seeds of the figure and of the ground say of every pixel's colour.
cv::Mat colour_odds(const FigureEvidence& evidence) {
  const cv::Mat colours = smooth_colours(evidence.image), indices = colour_indices(colours);
  Histogram ground = histogram(indices, evidence.ground_seeds);
  add_shadow(colours, evidence.ground_seeds, ground);
  const Histogram figure = histogram(indices, evidence.figure_seeds);
  cv::Mat odds = colour_odds(indices, figure, ground);

  // Seeds cover the table that shows through a handle: learn again without what looks like the table, unless
  // that is much of the object.
  cv::Mat around;
  cv::boxFilter(odds, around, CV_32F, {3, 3});
  const cv::Mat own = evidence.figure_seeds & (around > -1);
  if (cv::countNonZero(own) < 0.7 * cv::countNonZero(evidence.figure_seeds)) return odds;
  return colour_odds(indices, histogram(indices, own), ground);
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
  const cv::Mat odds = evidence.log_odds + colour_odds(evidence);

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

  constexpr double smoothness = 6;
  cv::detail::GCGraph<double> graph(static_cast<unsigned>(width * height),
                                    static_cast<unsigned>(4 * width * height));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int vertex = graph.addVtx();
      const double here = odds.at<float>(v, u);
      graph.addTermWeights(vertex, std::max(here, 0.0), std::max(-here, 0.0));
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
