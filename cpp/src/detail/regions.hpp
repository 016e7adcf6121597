#pragma once
#include <array>
#include <cstddef>
#include <map>
#include <opencv2/core.hpp>
#include <vector>

#include "detail/scene_cues.hpp"
#include "detail/superpixels.hpp"

namespace graspctx::detail {

/// Sums over the pixels of a region. Those of two regions joined are the sums of both.
struct RegionSums {
  double area = 0, at_border = 0;
  double u = 0, v = 0, uu = 0, uv = 0, vv = 0;
  std::array<double, 3> lab{}, lab_squared{};
  // What is matched over the plane: pixels, those above the plane surely and probably, on it, below it.
  double known = 0, raised = 0, perhaps_raised = 0, on_plane = 0, below_plane = 0;
  double residual_px = 0, residual_sigmas = 0, height_m = 0;          // bounded
  double dense_known = 0, dense_residual_px = 0, dense_height_m = 0;  // bounded
  double table_misfit = 0, table_likeness = 0, inside_table_m = 0;
  double plain_sigmas = 0, plain_light = 0, plain_off_hue = 0, on_plain_table = 0;
  double first_guess = 0;
  // Of the disparity d: moments with the pixel, and of the points in the camera frame (m).
  double deep = 0, deep_u = 0, deep_v = 0, deep_uu = 0, deep_uv = 0, deep_vv = 0;
  double d = 0, du = 0, dv = 0, dd = 0;
  std::array<double, 3> point{};
  std::array<double, 6> point_squared{};  // xx xy xz yy yz zz
  double foreground = 0;                  // probability times area
  void add(const RegionSums& other);
};

constexpr std::size_t height_bins = 32, colour_cells = 150;

/// Pixels by the piece they are part of (from 1).
using Pieces = std::map<int, double>;

struct Region {
  RegionSums sums;
  std::array<float, height_bins> heights{};   // pixels by height, 1 cm each from -2 cm
  std::array<float, colour_cells> colours{};  // pixels by lightness (6), a and b (5 each)
  Pieces guessed, raised;                     // see SceneCues
  double perimeter_px = 0;
  double ground_px = 0;  // of the perimeter, where it borders on what is no foreground
  void add(const Region& other);
};

/// Where two regions meet, pixel by pixel of their boundary.
struct Border {
  double length_px = 0, colour_step = 0;
  std::array<double, 8> colour_steps{};            // boundary by the size of the step in colour
  double known = 0, step_px = 0, large_steps = 0;  // of the residual over the plane
  double dense_known = 0, dense_step_px = 0, dense_large_steps = 0;  // of the first pass
  void add(const Border& other);
};

struct RegionGraph {
  std::vector<Region> regions;
  Pieces guessed, raised;                      // of the whole view
  std::vector<std::map<int, Border>> borders;  // of each region, by its neighbour; both have the same
};

RegionGraph region_graph(const SceneCues& cues, const Superpixels& superpixels);

}  // namespace graspctx::detail
