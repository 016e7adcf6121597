#include "detail/superpixels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "detail/disjoint_sets.hpp"

namespace graspctx::detail {

namespace {

constexpr double blur_px = 0.8;
constexpr float slack = 40;  // grey levels times pixels
constexpr int least_px = 20;
constexpr int steps_per_level = 8;  // edges are sorted by their strength in eighths of a grey level

struct Edge {
  int a, b;
  float strength;  // Euclidean difference of colour, grey levels
};

/// Edges between neighbouring pixels, the weakest first.
std::vector<Edge> sorted_edges(const cv::Mat& smooth) {
  constexpr std::array<std::array<int, 2>, 4> steps{{{1, 0}, {0, 1}, {1, 1}, {-1, 1}}};
  std::vector<Edge> edges;
  edges.reserve(4 * smooth.total());
  for (int v = 0; v < smooth.rows; ++v) {
    for (int u = 0; u < smooth.cols; ++u) {
      for (const auto& [du, dv] : steps) {
        if (u + du < 0 || u + du >= smooth.cols || v + dv >= smooth.rows) continue;
        const cv::Vec3f apart = smooth.at<cv::Vec3f>(v, u) - smooth.at<cv::Vec3f>(v + dv, u + du);
        edges.push_back({v * smooth.cols + u, (v + dv) * smooth.cols + u + du, std::sqrt(apart.dot(apart))});
      }
    }
  }
  // Counting sort: stable, and fast.
  const auto bin = [](const Edge& edge) { return static_cast<std::size_t>(edge.strength * steps_per_level); };
  std::size_t bins = 1;
  for (const Edge& edge : edges) bins = std::max(bins, bin(edge) + 1);
  std::vector<std::size_t> next(bins + 1, 0);
  for (const Edge& edge : edges) ++next[bin(edge) + 1];
  for (std::size_t i = 1; i < next.size(); ++i) next[i] += next[i - 1];
  std::vector<Edge> sorted(edges.size());
  for (const Edge& edge : edges) sorted[next[bin(edge)]++] = edge;
  return sorted;
}

}  // namespace

Superpixels find_superpixels(const cv::Mat& image) {
  cv::Mat smooth = image;
  if (image.channels() == 1) cv::cvtColor(image, smooth, cv::COLOR_GRAY2BGR);
  smooth.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {0, 0}, blur_px);
  const std::vector<Edge> edges = sorted_edges(smooth);

  const int pixels = static_cast<int>(smooth.total());
  DisjointSets sets(pixels);
  std::vector<int> size(static_cast<std::size_t>(pixels), 1);
  std::vector<float> limit(static_cast<std::size_t>(pixels), slack);  // strongest edge that may still join
  const auto join = [&](int a, int b) {
    sets.join(a, b);
    const int root = std::min(a, b);
    size[static_cast<std::size_t>(root)] =
        size[static_cast<std::size_t>(a)] + size[static_cast<std::size_t>(b)];
    return static_cast<std::size_t>(root);
  };
  for (const Edge& edge : edges) {
    const int a = sets.root(edge.a), b = sets.root(edge.b);
    if (a == b) continue;
    if (edge.strength > std::min(limit[static_cast<std::size_t>(a)], limit[static_cast<std::size_t>(b)]))
      continue;
    const std::size_t root = join(a, b);
    limit[root] = edge.strength + slack / static_cast<float>(size[root]);
  }
  for (const Edge& edge : edges) {
    const int a = sets.root(edge.a), b = sets.root(edge.b);
    if (a == b) continue;
    if (std::min(size[static_cast<std::size_t>(a)], size[static_cast<std::size_t>(b)]) < least_px) join(a, b);
  }

  Superpixels result{cv::Mat(smooth.size(), CV_32SC1), 0};
  std::vector<int> names(static_cast<std::size_t>(pixels), -1);
  for (int at = 0; at < pixels; ++at) {
    int& name = names[static_cast<std::size_t>(sets.root(at))];
    if (name < 0) name = result.count++;
    result.labels.ptr<int>()[at] = name;
  }
  return result;
}

}  // namespace graspctx::detail
