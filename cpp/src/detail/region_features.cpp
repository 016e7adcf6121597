#include "detail/region_features.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace graspctx::detail {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

double share(double part, double whole) {
  return whole > 0 ? part / whole : unknown;
}

double spread(const RegionSums& s, std::size_t channel) {
  const double mean = s.lab[channel] / s.area;
  return std::sqrt(std::max(s.lab_squared[channel] / s.area - mean * mean, 0.0));
}
double chroma_spread(const RegionSums& s) {
  return std::hypot(spread(s, 1), spread(s, 2));
}

/// The ellipse of the same second moments.
struct Ellipse {
  double fill;  // the region's area over its own: 1 for an ellipse, less for what is bent or scattered
  double major, minor;  // standard deviations, px
  double angle;
  explicit Ellipse(const RegionSums& s) {
    constexpr double pixel = 1.0 / 12;
    const double mu = s.u / s.area, mv = s.v / s.area;
    const double a = s.uu / s.area - mu * mu + pixel, b = s.uv / s.area - mu * mv;
    const double c = s.vv / s.area - mv * mv + pixel;
    const double det = std::max(a * c - b * b, 1e-3), half = (a + c) / 2;
    const double root = std::sqrt(std::max(half * half - det, 0.0));
    fill = s.area / (4 * CV_PI * std::sqrt(det));
    major = std::sqrt(std::max(half + root, 1e-3));
    minor = std::sqrt(std::max(half - root, 1e-2));
    angle = 0.5 * std::atan2(2 * b, a - c);
  }
};

/// What is left of the disparities when a plane is fitted through them: standard deviation, px.
double off_own_plane_px(const RegionSums& s) {
  if (s.deep < 1) return unknown;
  const double n = s.deep, mu = s.deep_u / n, mv = s.deep_v / n, md = s.d / n;
  constexpr double damping = 0.1;
  const double a = s.deep_uu / n - mu * mu + damping, b = s.deep_uv / n - mu * mv;
  const double c = s.deep_vv / n - mv * mv + damping;
  const double p = s.du / n - mu * md, q = s.dv / n - mv * md, variance = std::max(s.dd / n - md * md, 0.0);
  const double det = std::max(a * c - b * b, 1e-6);
  const double x = (c * p - b * q) / det, y = (a * q - b * p) / det;
  return std::sqrt(std::max(variance - x * p - y * q, 0.0));
}

constexpr double least_deep = 3;

Eigen::Vector3d middle_m(const RegionSums& s) {
  return Eigen::Vector3d(s.point[0], s.point[1], s.point[2]) / s.deep;
}

/// The standard deviation of its points along their longest axis, m.
double extent_m(const RegionSums& s) {
  if (s.deep < least_deep) return unknown;
  const Eigen::Vector3d mean = middle_m(s);
  Eigen::Matrix3d moments;
  moments << s.point_squared[0], s.point_squared[1], s.point_squared[2], s.point_squared[1],
      s.point_squared[3], s.point_squared[4], s.point_squared[2], s.point_squared[4], s.point_squared[5];
  const Eigen::Matrix3d covariance = moments / s.deep - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance, Eigen::EigenvaluesOnly);  // exact enough for the largest, and fast
  return std::sqrt(std::max(solver.eigenvalues()[2], 0.0));
}

/// The height (m) that a share of the region's pixels does not reach, down to the centimetre.
double height_quantile_m(const Region& region, double quantile) {
  const double all = std::accumulate(region.heights.begin(), region.heights.end(), 0.0);
  if (all <= 0) return unknown;
  double sum = 0;
  int bin = 0;
  for (; bin < int(height_bins) - 1; ++bin) {
    sum += region.heights[std::size_t(bin)];
    if (sum >= quantile * all) break;
  }
  return 0.01 * bin - 0.02;
}

/// The step in colour that a share of the border does not reach, as the number of its class.
double colour_quantile(const Border& border, double quantile) {
  double sum = 0;
  int bin = 0;
  for (; bin < int(border.colour_steps.size()) - 1; ++bin) {
    sum += border.colour_steps[std::size_t(bin)];
    if (sum >= quantile * border.length_px) break;
  }
  return bin;
}

/// Shares and means that tell ground from figure.
void append_appearance(const RegionSums& s, Features& to) {
  for (const double value : {s.known / s.area,
                             share(s.raised, s.known),
                             share(s.perhaps_raised, s.known),
                             share(s.on_plane, s.known),
                             share(s.below_plane, s.known),
                             share(s.residual_px, s.known),
                             share(s.residual_sigmas, s.known),
                             share(s.height_m, s.known),
                             share(s.dense_residual_px, s.dense_known),
                             share(s.dense_height_m, s.dense_known),
                             s.table_misfit / s.area,
                             s.table_likeness / s.area,
                             s.inside_table_m / s.area,
                             s.plain_sigmas / s.area,
                             s.plain_light / s.area,
                             s.plain_off_hue / s.area,
                             s.on_plain_table / s.area,
                             s.first_guess / s.area,
                             s.lab[0] / s.area,
                             std::hypot(s.lab[1] / s.area - 128, s.lab[2] / s.area - 128),
                             spread(s, 0)}) {
    to.push_back(static_cast<float>(value));
  }
}

double sum_of(const Pieces& pieces) {
  return std::accumulate(pieces.begin(), pieces.end(), 0.0,
                         [](double sum, const auto& piece) { return sum + piece.second; });
}

/// Of the pixels of two regions that are part of a piece, the share that is part of the same one.
double same_pieces(const Pieces& a, const Pieces& b) {
  constexpr double least_px = 5;
  const double of_a = sum_of(a), of_b = sum_of(b);
  if (of_a < least_px || of_b < least_px) return unknown;
  double same = 0;
  for (const auto& [piece, area] : a) {
    const auto other = b.find(piece);
    if (other != b.end()) same += std::min(area / of_a, other->second / of_b);
  }
  return same;
}

/// How much of the region its pieces are, how much of that the largest, and how much of the largest it holds.
void append_main_piece(const Pieces& own, const Pieces& whole, double area, Features& to) {
  int main = 0;
  double largest = 0;
  for (const auto& [piece, pixels] : own) {
    if (pixels <= largest) continue;
    main = piece;
    largest = pixels;
  }
  const double sum = sum_of(own);
  to.push_back(static_cast<float>(sum / area));
  to.push_back(static_cast<float>(share(largest, sum)));
  to.push_back(static_cast<float>(main > 0 ? largest / whole.at(main) : unknown));
}

}  // namespace

Features foreground_features(const RegionGraph& graph, int region, const SceneCues& cues) {
  const Region& own = graph.regions[std::size_t(region)];
  const Ellipse ellipse(own.sums);
  Features features;
  for (const double value : {cues.has_plane ? 1.0 : 0.0, cues.has_plain_table ? 1.0 : 0.0,
                             std::log(own.sums.area), own.sums.at_border > 0 ? 1.0 : 0.0,
                             ellipse.major / ellipse.minor, sum_of(own.raised) / own.sums.area}) {
    features.push_back(static_cast<float>(value));
  }
  append_appearance(own.sums, features);
  // The same of what is around, weighted by the length of the border.
  Features around;
  double length_px = 0, colour_step = 0, raised_around = 0, weakest = unknown;
  std::vector<double> sums, weights;
  for (const auto& [neighbour, border] : graph.borders[std::size_t(region)]) {
    around.clear();
    append_appearance(graph.regions[std::size_t(neighbour)].sums, around);
    sums.resize(around.size());
    weights.resize(around.size());
    for (std::size_t i = 0; i < around.size(); ++i) {
      if (std::isnan(around[i])) continue;
      sums[i] += border.length_px * double(around[i]);
      weights[i] += border.length_px;
    }
    length_px += border.length_px;
    colour_step += border.colour_step;
    const Region& other = graph.regions[std::size_t(neighbour)];
    raised_around += border.length_px * sum_of(other.raised) / other.sums.area;
    weakest = std::fmin(weakest, border.colour_step / border.length_px);  // the other if one is unknown
  }
  for (const std::size_t i : {1, 3, 4, 5, 6, 9, 10, 11, 13, 14, 17}) {
    features.push_back(static_cast<float>(i < sums.size() ? share(sums[i], weights[i]) : unknown));
  }
  features.push_back(static_cast<float>(share(colour_step, length_px)));
  features.push_back(static_cast<float>(weakest));
  features.push_back(static_cast<float>(share(raised_around, length_px)));
  return features;
}

Features union_features(const Region& a, const Region& b, const Border& border) {
  const auto order = [](const Region& r) {  // of regions of one size, any order that is always the same
    return std::make_tuple(r.sums.area, r.perimeter_px, r.sums.lab[0], r.sums.v, r.sums.u);
  };
  const bool a_is_larger = order(a) >= order(b);
  const Region &large = a_is_larger ? a : b, &small = a_is_larger ? b : a;
  const RegionSums &x = large.sums, &y = small.sums;
  RegionSums z = x;
  z.add(y);
  const Ellipse ellipse_x(x), ellipse_y(y), ellipse_z(z);
  double alike = 0;  // intersection of the colour histograms
  for (std::size_t i = 0; i < colour_cells; ++i) {
    alike += std::min(large.colours[i] / x.area, small.colours[i] / y.area);
  }
  const double flat_x = off_own_plane_px(x), flat_y = off_own_plane_px(y), flat_z = off_own_plane_px(z);
  const double extent_x = extent_m(x), extent_y = extent_m(y), extent_z = extent_m(z);
  const bool deep = x.deep >= least_deep && y.deep >= least_deep;
  const double foot_x = height_quantile_m(large, 0.05), top_x = height_quantile_m(large, 0.95);
  const double foot_y = height_quantile_m(small, 0.05), top_y = height_quantile_m(small, 0.95);
  const auto mean_apart = [&](std::size_t c) { return x.lab[c] / x.area - y.lab[c] / y.area; };
  Features features;
  for (const double value : {std::log(x.area),
                             std::log(y.area),
                             std::log(border.length_px),
                             border.length_px / std::max(small.perimeter_px, 1.0),
                             border.length_px / std::max(large.perimeter_px, 1.0),
                             border.colour_step / border.length_px,
                             colour_quantile(border, 0.25),
                             colour_quantile(border, 0.5),
                             std::abs(mean_apart(0)),
                             std::hypot(mean_apart(1), mean_apart(2)),
                             alike,
                             spread(x, 0),
                             spread(y, 0),
                             chroma_spread(x),
                             chroma_spread(y),
                             share(border.step_px, border.known),
                             share(border.large_steps, border.known),
                             border.known / border.length_px,
                             share(border.dense_step_px, border.dense_known),
                             share(border.dense_large_steps, border.dense_known),
                             border.dense_known / border.length_px,
                             ellipse_x.fill,
                             ellipse_y.fill,
                             ellipse_z.fill,
                             ellipse_z.fill - std::min(ellipse_x.fill, ellipse_y.fill),
                             ellipse_x.major / ellipse_x.minor,
                             ellipse_y.major / ellipse_y.minor,
                             ellipse_z.major / ellipse_z.minor,
                             std::abs(std::sin(ellipse_x.angle - ellipse_y.angle)),
                             flat_x,
                             flat_y,
                             flat_z,
                             flat_z - std::fmax(flat_x, flat_y),  // of the known one
                             extent_x,
                             extent_y,
                             extent_z,
                             extent_z / std::max(extent_x, 1e-4),
                             deep ? (middle_m(x) - middle_m(y)).norm() : unknown,
                             x.deep / x.area,
                             y.deep / y.area,
                             foot_x,
                             top_x,
                             foot_y,
                             top_y,
                             top_x - top_y,
                             x.foreground / x.area,
                             y.foreground / y.area,
                             share(x.raised, x.known),
                             share(y.raised, y.known),
                             share(x.on_plane, x.known),
                             share(y.on_plane, y.known),
                             large.ground_px / std::max(large.perimeter_px, 1.0),
                             small.ground_px / std::max(small.perimeter_px, 1.0),
                             x.first_guess / x.area,
                             y.first_guess / y.area,
                             same_pieces(a.guessed, b.guessed),
                             same_pieces(a.raised, b.raised),
                             sum_of(large.raised) / x.area,
                             sum_of(small.raised) / y.area}) {
    features.push_back(static_cast<float>(value));
  }
  return features;
}

Features object_features(const RegionGraph& graph, int number) {
  const Region& region = graph.regions[std::size_t(number)];
  Border all_around;
  for (const auto& [neighbour, border] : graph.borders[std::size_t(number)]) all_around.add(border);
  const RegionSums& s = region.sums;
  const Ellipse ellipse(s);
  Features features;
  for (const double value : {std::log(s.area),
                             s.at_border > 0 ? 1.0 : 0.0,
                             ellipse.fill,
                             ellipse.major / ellipse.minor,
                             ellipse.minor,
                             s.foreground / s.area,
                             extent_m(s),
                             off_own_plane_px(s),
                             height_quantile_m(region, 0.05),
                             height_quantile_m(region, 0.5),
                             height_quantile_m(region, 0.95),
                             region.ground_px / std::max(region.perimeter_px, 1.0),
                             s.area / std::max(region.perimeter_px, 1.0),
                             all_around.colour_step / std::max(all_around.length_px, 1.0),
                             colour_quantile(all_around, 0.25),
                             share(all_around.step_px, all_around.known),
                             share(all_around.large_steps, all_around.known),
                             share(all_around.dense_large_steps, all_around.dense_known),
                             region.perimeter_px / std::sqrt(s.area),
                             chroma_spread(s)}) {
    features.push_back(static_cast<float>(value));
  }
  append_main_piece(region.guessed, graph.guessed, s.area, features);
  append_main_piece(region.raised, graph.raised, s.area, features);
  append_appearance(s, features);
  return features;
}

}  // namespace graspctx::detail
