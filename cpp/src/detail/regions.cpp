#include "detail/regions.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <type_traits>

namespace graspctx::detail {

namespace {

/// Adds the numbers of a struct that holds nothing else.
template <typename Sums>
void add_all(Sums& to, const Sums& from) {
  static_assert(std::is_trivially_copyable_v<Sums> && sizeof(Sums) % sizeof(double) == 0);
  auto* a = reinterpret_cast<double*>(&to);
  const auto* b = reinterpret_cast<const double*>(&from);
  for (std::size_t i = 0; i < sizeof(Sums) / sizeof(double); ++i) a[i] += b[i];
}

void add_pieces(Pieces& to, const Pieces& from) {
  for (const auto& [piece, area] : from) to[piece] += area;
}

constexpr float surely_px = 0.3F, probably_px = 0.15F, surely_sigmas = 3, probably_sigmas = 2;
constexpr float on_plane_px = 0.3F, below_px = -1;

void add_pixel(const SceneCues& cues, int v, int u, Region& region) {
  RegionSums& s = region.sums;
  s.area += 1;
  s.at_border += v == 0 || u == 0 || v == cues.image.rows - 1 || u == cues.image.cols - 1 ? 1 : 0;
  s.u += u;
  s.v += v;
  s.uu += double(u) * u;
  s.uv += double(u) * v;
  s.vv += double(v) * v;
  const auto& lab = cues.lab.at<cv::Vec3f>(v, u);
  for (int c = 0; c < 3; ++c) {
    s.lab[std::size_t(c)] += lab[c];
    s.lab_squared[std::size_t(c)] += double(lab[c]) * lab[c];
  }
  const auto cell_of = [](float value) { return std::clamp(int((value - 78) / 20), 0, 4); };
  region.colours[std::size_t(std::min(5, int(lab[0] / 43)) * 25 + cell_of(lab[1]) * 5 + cell_of(lab[2]))] +=
      1;

  const float r = cues.residual_px.at<float>(v, u), sigma = cues.sigma_px.at<float>(v, u);
  float height = cues.height_m.at<float>(v, u);
  if (!std::isnan(r)) {
    s.known += 1;
    s.raised += r > std::max(surely_px, surely_sigmas * sigma) ? 1 : 0;
    s.perhaps_raised += r > std::max(probably_px, probably_sigmas * sigma) ? 1 : 0;
    s.on_plane += std::abs(r) < on_plane_px ? 1 : 0;
    s.below_plane += r < below_px ? 1 : 0;
    s.residual_px += std::clamp(r, -5.0F, 20.0F);
    s.residual_sigmas += std::clamp(r / std::max(sigma, 0.02F), -20.0F, 20.0F);
    s.height_m += std::isnan(height) ? 0 : std::clamp(height, -0.05F, 0.4F);
  }
  const float dense = cues.dense_px.at<float>(v, u), dense_height = cues.dense_height_m.at<float>(v, u);
  if (!std::isnan(dense)) {
    s.dense_known += 1;
    s.dense_residual_px += std::clamp(dense, -5.0F, 20.0F);
    s.dense_height_m += std::isnan(dense_height) ? 0 : std::clamp(dense_height, -0.05F, 0.4F);
  }
  if (std::isnan(height)) height = dense_height;
  if (!std::isnan(height)) {
    // Bounded before it becomes an integer: far heights are beyond any.
    const float bin = std::clamp((height + 0.02F) / 0.01F, 0.0F, float(height_bins - 1));
    region.heights[std::size_t(bin)] += 1;
  }
  s.table_misfit += cues.table_misfit.at<float>(v, u);
  s.table_likeness += cues.table_likeness.at<float>(v, u);
  s.inside_table_m += std::clamp(cues.inside_table_m.at<float>(v, u), -0.13F, 0.13F);
  s.plain_sigmas += std::min(cues.plain_sigmas.at<float>(v, u), 30.0F);
  s.plain_light += std::min(cues.plain_light.at<float>(v, u), 3.0F);
  s.plain_off_hue += std::min(cues.plain_off_hue.at<float>(v, u), 3.0F);
  s.on_plain_table += cues.on_plain_table.at<uchar>(v, u) ? 1 : 0;

  s.first_guess += cues.first_guess.at<uchar>(v, u) ? 1 : 0;
  if (const int piece = cues.guess_piece.at<int>(v, u)) region.guessed[piece] += 1;
  if (const int piece = cues.raised_piece.at<int>(v, u)) region.raised[piece] += 1;

  const auto& p = cues.point_m.at<cv::Vec3f>(v, u);
  if (!std::isnan(p[2])) {
    const double d = cues.disparity_px.at<float>(v, u);
    s.deep += 1;
    s.deep_u += u;
    s.deep_v += v;
    s.deep_uu += double(u) * u;
    s.deep_uv += double(u) * v;
    s.deep_vv += double(v) * v;
    s.d += d;
    s.du += d * u;
    s.dv += d * v;
    s.dd += d * d;
    std::size_t k = 0;
    for (int i = 0; i < 3; ++i) {
      s.point[std::size_t(i)] += p[i];
      for (int j = i; j < 3; ++j) s.point_squared[k++] += double(p[i]) * p[j];
    }
  }
}

/// What the boundary between a pixel and the one right of it or below shows. The pixels beside it mix the
/// colours of both: those one farther are compared, and depths two farther.
Border boundary_pixel(const SceneCues& cues, const cv::Mat& smooth, const cv::Point& a,
                      const cv::Point& step) {
  const cv::Point last(cues.image.cols - 1, cues.image.rows - 1);
  const auto at = [&](int steps) {
    const cv::Point p = a + steps * step;
    return cv::Point(std::clamp(p.x, 0, last.x), std::clamp(p.y, 0, last.y));
  };
  Border border;
  border.length_px = 1;
  const cv::Vec3f apart = smooth.at<cv::Vec3f>(at(-1)) - smooth.at<cv::Vec3f>(at(2));
  const float colour = std::max({std::abs(apart[0]), std::abs(apart[1]), std::abs(apart[2])});
  border.colour_step = colour;
  constexpr std::array<float, 7> limits{3, 6, 10, 16, 25, 40, 70};
  const auto bin = std::upper_bound(limits.begin(), limits.end(), colour) - limits.begin();
  border.colour_steps[std::size_t(bin)] = 1;
  constexpr float most_px = 8, large_px = 0.8F;
  const float step_px = std::abs(cues.residual_px.at<float>(at(-2)) - cues.residual_px.at<float>(at(3)));
  if (!std::isnan(step_px)) {
    border.known = 1;
    border.step_px = std::min(step_px, most_px);
    border.large_steps = step_px > large_px ? 1 : 0;
  }
  const float dense_px = std::abs(cues.disparity_px.at<float>(at(-2)) - cues.disparity_px.at<float>(at(3)));
  if (!std::isnan(dense_px)) {
    border.dense_known = 1;
    border.dense_step_px = std::min(dense_px, most_px);
    border.dense_large_steps = dense_px > large_px ? 1 : 0;
  }
  return border;
}

}  // namespace

void RegionSums::add(const RegionSums& other) {
  add_all(*this, other);
}

void Region::add(const Region& other) {
  sums.add(other.sums);
  ground_px += other.ground_px;
  add_pieces(guessed, other.guessed);
  add_pieces(raised, other.raised);
  for (std::size_t i = 0; i < heights.size(); ++i) heights[i] += other.heights[i];
  for (std::size_t i = 0; i < colours.size(); ++i) colours[i] += other.colours[i];
}

void Border::add(const Border& other) {
  add_all(*this, other);
}

RegionGraph region_graph(const SceneCues& cues, const Superpixels& superpixels) {
  RegionGraph graph;
  graph.regions.resize(std::size_t(superpixels.count));
  graph.borders.resize(graph.regions.size());
  cv::Mat smooth;
  cues.image.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {0, 0}, 1);
  const cv::Mat& labels = superpixels.labels;
  for (int v = 0; v < labels.rows; ++v) {
    for (int u = 0; u < labels.cols; ++u) {
      const int here = labels.at<int>(v, u);
      add_pixel(cues, v, u, graph.regions[std::size_t(here)]);
      for (const cv::Point& step : {cv::Point(1, 0), cv::Point(0, 1)}) {
        if (u + step.x >= labels.cols || v + step.y >= labels.rows) continue;
        const int there = labels.at<int>(v + step.y, u + step.x);
        if (here == there) continue;
        graph.borders[std::size_t(std::min(here, there))][std::max(here, there)].add(
            boundary_pixel(cues, smooth, {u, v}, step));
        graph.regions[std::size_t(here)].perimeter_px += 1;
        graph.regions[std::size_t(there)].perimeter_px += 1;
      }
    }
  }
  for (const Region& region : graph.regions) {
    add_pieces(graph.guessed, region.guessed);
    add_pieces(graph.raised, region.raised);
  }
  for (int a = 0; a < superpixels.count; ++a) {
    for (const auto& [b, border] : graph.borders[std::size_t(a)]) {
      if (a < b) graph.borders[std::size_t(b)][a] = border;
    }
  }
  return graph;
}

}  // namespace graspctx::detail
