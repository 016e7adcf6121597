#include "detail/depth_hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "detail/background_planes.hpp"
#include "detail/masks.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/quantile.hpp"
#include "detail/texture.hpp"

namespace graspctx::detail {

namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

cv::Mat near_zero_disparity(const cv::Mat& disparity, double fixated_px, double band_px) {
  cv::Mat mask;
  cv::inRange(disparity, fixated_px - band_px, fixated_px + band_px, mask);
  return mask;
}

/// What counts as a step in depth rather than a slope.
double step_in_depth_px(double shifted_px) {
  return std::max(1.0, 0.015 * shifted_px);
}

/// The steps in depth of a line of cells: step[i] leads from cell i to the next. What the surfaces on both
/// sides rise or fall by anyway is no step; one that takes some cells is at its steepest.
void find_steps(const float* disparity, std::ptrdiff_t stride, int count, double doffs_px,
                std::vector<float>& excess, std::vector<signed char>& step) {
  constexpr int half = 1, flank = 4;
  const auto at = [&](int i) { return disparity[i * stride]; };
  const auto walk = [&](int from, int direction, int cells) {
    while (cells-- > 0 && from + direction >= 0 && from + direction < count &&
           !std::isnan(at(from + direction)))
      from += direction;
    return from;
  };
  excess.assign(static_cast<std::size_t>(count), 0);
  step.assign(static_cast<std::size_t>(count), 0);
  for (int i = 0; i + 1 < count; ++i) {
    if (std::isnan(at(i)) || std::isnan(at(i + 1))) continue;
    const int a = walk(i, -1, half), b = walk(i + 1, 1, half);
    const float change = at(b) - at(a);
    if (change == 0) continue;
    const int before = walk(a, -1, flank), after = walk(b, 1, flank);
    const auto slope = [&](int from, int to) {
      return to > from
                 ? std::max((at(to) - at(from)) / static_cast<float>(to - from) * (change > 0 ? 1 : -1), 0.F)
                 : 0.F;
    };
    const float explained = std::min(slope(before, a), slope(b, after)) * static_cast<float>(b - a);
    const float rest = std::max(std::abs(change) - explained, 0.F);
    if (rest > step_in_depth_px(std::max(at(a), at(b)) + doffs_px)) {
      excess[static_cast<std::size_t>(i)] = change > 0 ? rest : -rest;
    }
  }
  for (int i = 0; i + 1 < count; ++i) {
    const float here = excess[static_cast<std::size_t>(i)];
    if (here == 0) continue;
    const auto steepness = [&](int k) { return std::abs(at(k + 1) - at(k)); };
    bool steepest = true;
    for (int k = std::max(0, i - half); k <= std::min(count - 2, i + half); ++k) {
      const float there = excess[static_cast<std::size_t>(k)];
      if (k == i || there * here <= 0) continue;
      steepest &= k < i ? steepness(i) > steepness(k) : steepness(i) >= steepness(k);
    }
    if (steepest) step[static_cast<std::size_t>(i)] = here > 0 ? 1 : -1;
  }
}

/// The view as coarse as it takes to find objects in it: every size in cells is a share of the view.
struct CoarseView {
  int cell_px;
  cv::Mat disparity;  // CV_32FC1, px of the full view; what is hidden from the right view is ground
  cv::Mat reliable;   // CV_8UC1, > 0 where both views agree
  cv::Mat step_right, step_below;  // CV_8SC1, to the next cell: -1 down in depth, 1 up, 0 none or unknown
  cv::Rect looked_at;              // cells; what leaves them is cut off
  const StereoCamera* camera;

  CoarseView(const Disparity& full, const StereoCamera& camera, const std::optional<cv::Rect>& box_px);
  double shifted(float disparity_px) const { return disparity_px + camera->doffs_px; }
  bool contains(const cv::Point& cell) const { return cv::Rect({0, 0}, disparity.size()).contains(cell); }
  /// The first step met from a cell outwards, along an axis: -1 down, 1 up, 0 none within so many cells.
  int step_out(const cv::Point& cell, const cv::Point& outwards, int cells) const {
    const cv::Mat& steps = outwards.x != 0 ? step_right : step_below;
    const int sign = outwards.x + outwards.y;
    cv::Point from = sign > 0 ? cell : cell + outwards;
    for (; cells > 0 && contains(from); --cells, from += outwards) {
      if (const int step = steps.at<signed char>(from)) return sign * step;
    }
    return 0;
  }
  double metres(double cells, float disparity_px) const {
    return cells * cell_px * camera->baseline_m / shifted(disparity_px);
  }
};

CoarseView::CoarseView(const Disparity& full, const StereoCamera& stereo_camera,
                       const std::optional<cv::Rect>& box_px)
    : camera(&stereo_camera) {
  constexpr double wanted_columns = 320;
  cell_px = std::max(1, static_cast<int>(std::lround(full.dense.cols / wanted_columns)));
  const cv::Size size(std::max(1, full.dense.cols / cell_px), std::max(1, full.dense.rows / cell_px));
  cv::Mat known;
  cv::resize(full.dense, disparity, size, 0, 0, cv::INTER_NEAREST);
  cv::resize(full.reliable, known, size, 0, 0, cv::INTER_NEAREST);
  known = without_hidden_strips(known, cell_px);
  reliable = known == known;
  for (int v = 0; v < disparity.rows; ++v) {
    auto* row = disparity.ptr<float>(v);
    for (int u = 0; u < disparity.cols; ++u) {
      if (!(shifted(row[u]) > 0)) row[u] = unknown;
    }
  }
  disparity = without_hidden_strips(disparity, cell_px);
  looked_at = cv::Rect({0, 0}, size);
  if (box_px) {
    const cv::Point last((box_px->br().x - 1) / cell_px, (box_px->br().y - 1) / cell_px);
    looked_at &= cv::Rect(box_px->tl() / cell_px, last + cv::Point(1, 1));
  }
  step_right = cv::Mat::zeros(size, CV_8SC1);
  step_below = cv::Mat::zeros(size, CV_8SC1);
  std::vector<float> excess;
  std::vector<signed char> steps;
  for (int v = 0; v < size.height; ++v) {
    find_steps(disparity.ptr<float>(v), 1, size.width, camera->doffs_px, excess, steps);
    std::copy(steps.begin(), steps.end(), step_right.ptr<signed char>(v));
  }
  for (int u = 0; u < size.width; ++u) {
    find_steps(disparity.ptr<float>(0) + u, static_cast<std::ptrdiff_t>(disparity.step1()), size.height,
               camera->doffs_px, excess, steps);
    for (int v = 0; v < size.height; ++v)
      step_below.at<signed char>(v, u) = steps[static_cast<std::size_t>(v)];
  }
}

/// A box may run a little inside the step that it is drawn around.
constexpr int cut_reach_cells = 4;

/// Neighbouring cells of a row between two steps in depth.
struct Run {
  int v, first, last;
};

/// The runs that end in a step down on one side at least, and are not longer than objects are.
std::vector<Run> runs_between_steps(const CoarseView& view, double longest_m) {
  std::vector<Run> runs;
  const cv::Rect& box = view.looked_at;
  for (int v = box.y; v < box.br().y; ++v) {
    const auto* row = view.disparity.ptr<float>(v);
    const auto* step = view.step_right.ptr<signed char>(v);
    for (int u = box.x; u < box.br().x; ++u) {
      if (std::isnan(row[u])) continue;
      int last = u;
      while (last + 1 < box.br().x && !std::isnan(row[last + 1]) && step[last] == 0) ++last;
      const int left = view.step_out({u, v}, {-1, 0}, u == box.x ? cut_reach_cells : 1);
      const int right = view.step_out({last, v}, {1, 0}, last + 1 == box.br().x ? cut_reach_cells : 1);
      const bool steps_down = std::min(left, right) < 0;
      const float middle = row[(u + last) / 2];
      if (steps_down && view.metres(last - u + 1, middle) <= longest_m) runs.push_back({v, u, last});
      u = last;
    }
  }
  return runs;
}

/// Runs of neighbouring rows that go on in depth. likeness: what they share of the columns they cover.
struct Link {
  int above, below;
  double likeness;
};

std::vector<Link> links_between(const std::vector<Run>& runs, const CoarseView& view) {
  std::vector<Link> links;
  std::size_t next = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    while (next < runs.size() && (runs[next].v <= runs[i].v ||
                                  (runs[next].v == runs[i].v + 1 && runs[next].last < runs[i].first))) {
      ++next;
    }
    for (std::size_t k = next; k < runs.size() && runs[k].v == runs[i].v + 1 && runs[k].first <= runs[i].last;
         ++k) {
      const int first = std::max(runs[i].first, runs[k].first), last = std::min(runs[i].last, runs[k].last);
      if (last < first) continue;
      int going_on = 0;
      for (int u = first; u <= last; ++u) {
        const float above = view.disparity.at<float>(runs[i].v, u);
        const float below = view.disparity.at<float>(runs[k].v, u);
        going_on += std::abs(above - below) <= step_in_depth_px(view.shifted(std::max(above, below))) ? 1 : 0;
      }
      if (2 * going_on <= last - first + 1) continue;
      const double all = std::max(runs[i].last, runs[k].last) - std::min(runs[i].first, runs[k].first) + 1;
      links.push_back({static_cast<int>(i), static_cast<int>(k), (last - first + 1) / all});
    }
  }
  std::stable_sort(links.begin(), links.end(),
                   [](const Link& a, const Link& b) { return a.likeness > b.likeness; });
  return links;
}

/// Runs put together, the most alike first. A piece that was joined where the width jumps remembers its
/// parts.
struct Piece {
  std::vector<int> runs;
  int parts[2] = {-1, -1};
};

/// All pieces; whole: those that are no part of another.
std::vector<Piece> pieces_of(const std::vector<Run>& runs, const std::vector<Link>& links,
                             std::vector<int>& whole) {
  constexpr double alike = 0.6;
  std::vector<Piece> pieces(runs.size());
  std::vector<int> owner(runs.size());
  std::iota(owner.begin(), owner.end(), 0);
  for (std::size_t i = 0; i < runs.size(); ++i) pieces[i].runs = {static_cast<int>(i)};
  const auto give = [&](int from, int to) {
    for (const int run : pieces[static_cast<std::size_t>(from)].runs)
      owner[static_cast<std::size_t>(run)] = to;
  };
  for (const Link& link : links) {
    int a = owner[static_cast<std::size_t>(link.above)], b = owner[static_cast<std::size_t>(link.below)];
    if (a == b) continue;
    auto* large = &pieces[static_cast<std::size_t>(a)];
    auto* small = &pieces[static_cast<std::size_t>(b)];
    if (large->runs.size() < small->runs.size()) {
      std::swap(large, small);
      std::swap(a, b);
    }
    if (link.likeness >= alike) {
      give(b, a);
      large->runs.insert(large->runs.end(), small->runs.begin(), small->runs.end());
      small->runs.clear();
      continue;
    }
    Piece joined;
    joined.runs = large->runs;
    joined.runs.insert(joined.runs.end(), small->runs.begin(), small->runs.end());
    joined.parts[0] = a;
    joined.parts[1] = b;
    const int id = static_cast<int>(pieces.size());
    give(a, id);
    give(b, id);
    pieces.push_back(std::move(joined));
  }
  std::vector<char> is_whole(pieces.size(), 0);
  for (const int id : owner) is_whole[static_cast<std::size_t>(id)] = 1;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (is_whole[i]) whole.push_back(static_cast<int>(i));
  }
  return pieces;
}

/// A piece as a mask, and how its outline runs.
struct Outlined {
  cv::Rect box;  // cells
  cv::Mat mask;
  int cells = 0, reliable = 0;
  int down = 0, level = 0, up = 0, open = 0;  // cells of the outline by what is behind it
  float nearest = 0, farthest = 0, median = 0;

  double down_share() const { return down / std::max(1.0, double(down + level + up)); }
};

Outlined outlined(const Piece& piece, const std::vector<Run>& runs, const CoarseView& view) {
  Outlined o;
  for (const int id : piece.runs) {
    const Run& run = runs[static_cast<std::size_t>(id)];
    o.box |= cv::Rect(run.first, run.v, run.last - run.first + 1, 1);
  }
  o.mask = cv::Mat::zeros(o.box.size(), CV_8UC1);
  for (const int id : piece.runs) {
    const Run& run = runs[static_cast<std::size_t>(id)];
    o.mask.row(run.v - o.box.y).colRange(run.first - o.box.x, run.last + 1 - o.box.x).setTo(255);
  }
  std::vector<float> disparities;
  const cv::Rect inside({0, 0}, o.box.size());
  for (int v = 0; v < o.box.height; ++v) {
    for (int u = 0; u < o.box.width; ++u) {
      if (!o.mask.at<uchar>(v, u)) continue;
      const cv::Point here(u, v), at = here + o.box.tl();
      const float d = view.disparity.at<float>(at);
      disparities.push_back(d);
      o.reliable += view.reliable.at<uchar>(at) ? 1 : 0;
      for (const cv::Point& step : {cv::Point(-1, 0), cv::Point(1, 0), cv::Point(0, -1), cv::Point(0, 1)}) {
        const cv::Point there = here + step;
        if (inside.contains(there) && o.mask.at<uchar>(there)) continue;
        if (!view.looked_at.contains(at + step)) {
          ++(view.step_out(at, step, cut_reach_cells) < 0 ? o.down : o.open);
          continue;
        }
        constexpr int reach = 3;
        bool known = false;
        for (int i = 1; i <= reach && !known; ++i) {
          known = view.contains(at + i * step) && view.reliable.at<uchar>(at + i * step);
        }
        if (!known) {
          ++o.open;
          continue;
        }
        // The outline may miss the step by a cell.
        int change = view.step_out(at, step, 2);
        if (change == 0 && view.contains(at - step)) change = view.step_out(at - step, step, 1);
        ++(change < 0 ? o.down : change > 0 ? o.up : o.level);
      }
    }
  }
  o.cells = static_cast<int>(disparities.size());
  o.nearest = static_cast<float>(quantile(disparities, 0.95));
  o.farthest = static_cast<float>(quantile(disparities, 0.05));
  o.median = static_cast<float>(quantile(disparities, 0.5));
  return o;
}

/// How much better its own disparity explains what both views show of a piece than the disparity of what is
/// beside it: ratio of grey differences. Where nothing is to be seen, nothing explains it better.
double explained_by_itself(const Outlined& o, const CoarseView& view, const cv::Mat& left,
                           const cv::Mat& right, double noise) {
  double as_ground = 0, as_itself = 0, count = 0;
  for (int v = 0; v < o.box.height; ++v) {
    const auto* row = view.disparity.ptr<float>(o.box.y + v);
    for (int u = 0; u < o.box.width; ++u) {
      if (!o.mask.at<uchar>(v, u)) continue;
      int last = u;
      while (last + 1 < o.box.width && o.mask.at<uchar>(v, last + 1)) ++last;
      float ground = unknown;
      for (int i = 1; i <= cut_reach_cells; ++i) {
        const int before = o.box.x + u - i, after = o.box.x + last + i;
        if (before >= 0) ground = std::fmin(ground, row[before]);
        if (after < view.disparity.cols) ground = std::fmin(ground, row[after]);
      }
      for (; u <= last && !std::isnan(ground); ++u) {
        const int at_u = (o.box.x + u) * view.cell_px, at_v = (o.box.y + v) * view.cell_px;
        const auto here = static_cast<double>(left.at<uchar>(at_v, at_u));
        const auto difference = [&](double disparity) {
          const double u_right = std::clamp(at_u - disparity, 0.0, right.cols - 1.001);
          const int whole = static_cast<int>(u_right);
          const auto* from = right.ptr<uchar>(at_v);
          return std::abs(here - (from[whole] + (u_right - whole) * (from[whole + 1] - from[whole])));
        };
        as_ground += difference(ground);
        as_itself += difference(row[o.box.x + u]);
        ++count;
      }
      u = last;
    }
  }
  return as_ground / std::max({as_itself, noise * count, 1e-9});
}

/// The plane that most of the scene lies on, if it reaches farther than objects do: a wall, or a table.
std::optional<BackgroundPlane> plane_of_scene(const cv::Mat& disparity_px, const StereoCamera& camera,
                                              double max_extent_m) {
  constexpr double most_of_scene = 0.5, within_px = 0.75, outliers = 0.05;
  const std::vector<BackgroundPlane> planes = background_planes(disparity_px, most_of_scene, 1);
  if (planes.empty()) return std::nullopt;
  std::vector<double> across_m, down_m;
  for (int v = 0; v < disparity_px.rows; v += 4) {
    for (int u = 0; u < disparity_px.cols; u += 4) {
      const double d = disparity_px.at<float>(v, u);
      // False for NaN.
      if (!(std::abs(planes.front().disparity_px(u, v) - d) < within_px && d + camera.doffs_px > 0)) continue;
      const Eigen::Vector3d point = camera.triangulate({double(u), double(v)}, d);
      across_m.push_back(point.x());
      down_m.push_back(point.y());
    }
  }
  if (across_m.empty()) return std::nullopt;
  const auto reach_m = [](const std::vector<double>& at_m) {
    return quantile(at_m, 1 - outliers) - quantile(at_m, outliers);
  };
  if (std::max(reach_m(across_m), reach_m(down_m)) <= max_extent_m) return std::nullopt;
  return planes.front();
}

/// How much better their own disparity explains what both views show of some pixels than a plane does: ratio
/// of grey differences, at the best of planes nearby. A wall whose texture repeats, or is hardly to be seen,
/// is matched wrongly in places, where the wall explains the views as well.
template <typename DisparityOf>
double explained_before(const BackgroundPlane& plane, const std::vector<cv::Point>& pixels,
                        const DisparityOf& own_px, const cv::Mat& left, const cv::Mat& right, double noise) {
  constexpr double farthest_px = 1, step_px = 0.25;
  const auto difference = [&](const cv::Point& at, double disparity) {
    const double u_right = std::clamp(at.x - disparity, 0.0, right.cols - 1.001);
    const int whole = static_cast<int>(u_right);
    const auto* from = right.ptr<uchar>(at.y);
    return std::abs(left.at<uchar>(at) - (from[whole] + (u_right - whole) * (from[whole + 1] - from[whole])));
  };
  double as_itself = 0, as_plane = std::numeric_limits<double>::infinity();
  for (const cv::Point& at : pixels) as_itself += difference(at, own_px(at));
  for (double beside = -farthest_px; beside <= farthest_px; beside += step_px) {
    double sum = 0;
    for (const cv::Point& at : pixels) sum += difference(at, plane.disparity_px(at.x, at.y) + beside);
    as_plane = std::min(as_plane, sum);
  }
  return as_plane / std::max({as_itself, noise * static_cast<double>(pixels.size()), 1e-9});
}

constexpr double least_explained = 1.3;  // times as well as by the background

/// too_large: not an object itself, though its parts may be.
enum class Verdict { object, too_large, no };

Verdict judge(const Outlined& o, const CoarseView& view, const SegmentationOptions& options) {
  constexpr int least_cells = 50;
  constexpr double least_reliable_share = 0.4;
  // In a box of the caller's there is an object: less of its outline has to show it.
  const double least_down_share = options.roi_px ? 0.4 : 0.6, most_open_share = options.roi_px ? 0.6 : 0.3;
  const double outline = o.down + o.level + o.up + o.open;
  if (o.cells < least_cells || o.reliable < least_reliable_share * o.cells) return Verdict::no;
  const double extent_m = view.metres(std::max(o.box.width, o.box.height), o.median);
  const double deep_m = view.camera->depth_m(o.farthest) - view.camera->depth_m(o.nearest);
  if (extent_m > options.max_extent_m || deep_m > options.max_extent_m) return Verdict::too_large;
  if (extent_m < options.min_extent_m) return Verdict::no;
  if (o.open > most_open_share * outline) return Verdict::no;
  return o.down_share() >= least_down_share ? Verdict::object : Verdict::too_large;
}

}  // namespace

cv::Mat without_hidden_strips(const cv::Mat& disparity, int cell_px) {
  constexpr int least_cells = 4;
  constexpr double at_most = 1.5;  // times the step in disparity
  cv::Mat filled = disparity.clone();
  for (int v = 0; v < filled.rows; ++v) {
    auto* row = filled.ptr<float>(v);
    for (int u = 0; u < filled.cols; ++u) {
      if (!std::isnan(row[u])) continue;
      int end = u;
      while (end < filled.cols && std::isnan(row[end])) ++end;
      if (u > 0 && end < filled.cols) {
        const float left = row[u - 1], right = row[end];
        if (end - u <= least_cells + at_most * std::abs(right - left) / cell_px) {
          std::fill(row + u, row + end, std::min(left, right));
        }
      }
      u = end;
    }
  }
  return filled;
}

double zero_disparity_band_px(double shifted_px) {
  return std::max(1.5, 0.06 * shifted_px);
}

std::vector<Hypothesis> hypotheses_by_disparity(const RectifiedPair& pair, const Disparity& disparity,
                                                const StereoCamera& camera,
                                                const SegmentationOptions& options) {
  const CoarseView view(disparity, camera, options.roi_px);
  const cv::Mat left = grey(pair.left), right = grey(pair.right);
  const double noise = noise_sigma(left);
  const auto wall = plane_of_scene(disparity.reliable, camera, options.max_extent_m);
  const std::vector<Run> runs = runs_between_steps(view, options.max_extent_m);
  std::vector<int> open;
  const std::vector<Piece> pieces = pieces_of(runs, links_between(runs, view), open);

  std::vector<Hypothesis> found;
  while (!open.empty()) {
    const Piece& piece = pieces[static_cast<std::size_t>(open.back())];
    open.pop_back();
    const Outlined outline = outlined(piece, runs, view);
    Verdict verdict = judge(outline, view, options);
    // Ground that comes along makes the outline worse, another part of the object better.
    if (verdict == Verdict::object && piece.parts[0] >= 0) {
      const Outlined part = outlined(pieces[static_cast<std::size_t>(piece.parts[0])], runs, view);
      if (judge(part, view, options) == Verdict::object && part.down_share() > outline.down_share() + 0.01) {
        verdict = Verdict::too_large;
      }
    }
    if (verdict == Verdict::too_large && piece.parts[0] >= 0) {
      open.insert(open.end(), std::begin(piece.parts), std::end(piece.parts));
    }
    if (verdict != Verdict::object) continue;
    if (explained_by_itself(outline, view, left, right, noise) < least_explained) continue;
    std::vector<cv::Point> pixels = where(outline.mask);
    for (cv::Point& at : pixels) at = (outline.box.tl() + at) * view.cell_px;
    const auto own_px = [&](const cv::Point& at) { return view.disparity.at<float>(at / view.cell_px); };
    if (wall && explained_before(*wall, pixels, own_px, left, right, noise) < least_explained) continue;
    Hypothesis hypothesis;
    hypothesis.seeds = cv::Mat::zeros(disparity.dense.size(), CV_8UC1);
    cv::Mat large;
    cv::resize(outline.mask, large, {}, view.cell_px, view.cell_px, cv::INTER_NEAREST);
    large.copyTo(hypothesis.seeds(cv::Rect(outline.box.tl() * view.cell_px, large.size())));
    hypothesis.disparity_px = outline.median;
    hypothesis.saliency = saliency_of(cv::countNonZero(large), hypothesis.disparity_px, camera);
    found.push_back(std::move(hypothesis));
  }
  sort_by_saliency(found);
  return found;
}

void drop_parts_of_wall(const RectifiedPair& pair, const Disparity& disparity, const StereoCamera& camera,
                        double max_extent_m, std::vector<Hypothesis>& hypotheses) {
  // The camera looks at a wall, or down on it by less than a quarter of a right angle; a table lies flatter.
  constexpr double steepest = 0.4;
  const auto wall = plane_of_scene(disparity.reliable, camera, max_extent_m);
  if (!wall || std::abs(plane_from_disparity(wall->coefficients, camera).normal.y()) > steepest) return;
  const cv::Mat left = grey(pair.left), right = grey(pair.right);
  const double noise = noise_sigma(left);
  const auto is_part = [&](const Hypothesis& hypothesis) {
    const auto own_px = [&](const cv::Point&) { return hypothesis.disparity_px; };
    return explained_before(*wall, where(hypothesis.seeds), own_px, left, right, noise) < least_explained;
  };
  hypotheses.erase(std::remove_if(hypotheses.begin(), hypotheses.end(), is_part), hypotheses.end());
}

cv::Mat disc_around(const cv::Point& centre, double radius_m, double disparity_px, const cv::Size& size,
                    const StereoCamera& camera) {
  const double radius_px = std::clamp(radius_m * (disparity_px + camera.doffs_px) / camera.baseline_m, 4.0,
                                      static_cast<double>(size.width + size.height));  // all of the image
  cv::Mat filled = cv::Mat::zeros(size, CV_8UC1);
  cv::circle(filled, centre, static_cast<int>(radius_px), 255, cv::FILLED);
  return filled;
}

std::optional<Hypothesis> hypothesis_at(const cv::Point& fixation, const Disparity& disparity,
                                        const StereoCamera& camera, const SegmentationOptions& options) {
  const cv::Size size = disparity.dense.size();
  const int near_px = std::max(2, size.width / 128);
  const cv::Rect around =
      cv::Rect(fixation.x - near_px, fixation.y - near_px, 2 * near_px + 1, 2 * near_px + 1) &
      cv::Rect({0, 0}, size);
  std::vector<float> near;
  for (const cv::Mat* map : {&disparity.reliable, &disparity.dense}) {
    for (int v = around.y; near.size() < 10 && v < around.br().y; ++v) {
      for (int u = around.x; u < around.br().x; ++u) {
        if (!std::isnan(map->at<float>(v, u))) near.push_back(map->at<float>(v, u));
      }
    }
  }
  if (near.empty()) return std::nullopt;
  Hypothesis hypothesis;
  hypothesis.disparity_px = quantile(near, 0.5);
  const double shifted_px = hypothesis.disparity_px + camera.doffs_px;
  if (shifted_px <= 0) return std::nullopt;

  const cv::Mat reach =
      disc_around(fixation, options.max_extent_m / 2, hypothesis.disparity_px, size, camera);
  const cv::Mat gaze = disc_around(fixation, gaze_m, hypothesis.disparity_px, size, camera);
  const cv::Mat at_zero =
      near_zero_disparity(disparity.dense, hypothesis.disparity_px, zero_disparity_band_px(shifted_px));
  const CoarseView view(disparity, camera, options.roi_px);
  cv::Mat standing = cv::Mat::zeros(size, CV_8UC1);
  for (const Run& run : runs_between_steps(view, options.max_extent_m)) {
    const cv::Rect cells(run.first, run.v, run.last - run.first + 1, 1);
    standing(cv::Rect(cells.tl() * view.cell_px, cells.br() * view.cell_px)).setTo(255);
  }
  standing &= reach & at_zero;
  hypothesis.seeds = parts_holding(standing, gaze, 1) | (gaze & at_zero);
  hypothesis.saliency = saliency_of(cv::countNonZero(hypothesis.seeds), hypothesis.disparity_px, camera);
  if (hypothesis.saliency <= 0) return std::nullopt;
  return hypothesis;
}

}  // namespace graspctx::detail
