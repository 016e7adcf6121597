#include "detail/raised_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "detail/disjoint_sets.hpp"
#include "detail/masks.hpp"
#include "detail/quantile.hpp"
#include "detail/texture.hpp"

namespace graspctx::detail {

namespace {

/// Connected parts of what is raised (CV_32SC1 from 1, 0 = none), cut at steps in height.
cv::Mat pieces_without_steps(const cv::Mat& raised, const cv::Mat& residual_px, int& count) {
  constexpr float step_px = 0.8F;
  constexpr std::array<std::pair<int, int>, 6> neighbours{{{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {2, 0}, {0, 2}}};
  const int rows = raised.rows, cols = raised.cols;
  DisjointSets sets(rows * cols);
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < cols; ++u) {
      if (!raised.at<uchar>(v, u)) continue;
      const float here = residual_px.at<float>(v, u);
      for (const auto& [du, dv] : neighbours) {
        const int u1 = u + du, v1 = v + dv;
        if (u1 < 0 || u1 >= cols || v1 >= rows || !raised.at<uchar>(v1, u1)) continue;
        if (std::abs(residual_px.at<float>(v1, u1) - here) < step_px) sets.join(v * cols + u, v1 * cols + u1);
      }
    }
  }
  std::vector<int> sizes(static_cast<std::size_t>(rows * cols)), names(sizes.size());
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < cols; ++u) {
      if (raised.at<uchar>(v, u)) ++sizes[static_cast<std::size_t>(sets.root(v * cols + u))];
    }
  }
  constexpr int least_px = 12;
  count = 0;
  cv::Mat pieces = cv::Mat::zeros(raised.size(), CV_32SC1);
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < cols; ++u) {
      if (!raised.at<uchar>(v, u)) continue;
      const auto root = static_cast<std::size_t>(sets.root(v * cols + u));
      if (sizes[root] < least_px) continue;
      if (names[root] == 0) names[root] = ++count;
      pieces.at<int>(v, u) = names[root];
    }
  }
  return pieces;
}

/// Largest difference of a channel.
int colour_step(const cv::Mat& image, const cv::Point& a, const cv::Point& b) {
  const int channels = image.channels();
  const uchar *x = image.ptr<uchar>(a.y) + a.x * channels, *y = image.ptr<uchar>(b.y) + b.x * channels;
  int largest = 0;
  for (int c = 0; c < channels; ++c) largest = std::max(largest, std::abs(int(x[c]) - int(y[c])));
  return largest;
}

/// The pieces grown over the pixels of unknown depth.
struct Basins {
  cv::Mat
      source;  // CV_32SC1: index of the pixel of known depth that a pixel was reached from, -1 if none was
  int piece(const cv::Mat& pieces, int at) const {
    const int from = source.ptr<int>()[at];
    return from < 0 ? 0 : pieces.ptr<int>()[from];
  }
};

/// Lets the pieces and the ground grow until they meet, where the colour changes most if it does (Meyer's
/// flooding).
Basins flood(const cv::Mat& pieces, const cv::Mat& smooth, const cv::Mat& ground) {
  Basins basins{cv::Mat(pieces.size(), CV_32SC1, cv::Scalar(-1))};
  cv::Mat done = ground.clone();
  const int cols = pieces.cols, rows = pieces.rows;
  constexpr int levels = 64;
  std::array<std::vector<std::pair<int, int>>, levels> waiting;  // pixel, where from
  auto* source = basins.source.ptr<int>();
  const auto neighbours_of = [&](int at, auto&& visit) {
    const int u = at % cols, v = at / cols;
    if (u > 0) visit(at - 1);
    if (u + 1 < cols) visit(at + 1);
    if (v > 0) visit(at - cols);
    if (v + 1 < rows) visit(at + cols);
  };
  const auto pixel = [cols](int at) { return cv::Point(at % cols, at / cols); };
  int level = 0;
  const auto spread = [&](int at) {
    neighbours_of(at, [&](int next) {
      if (done.ptr<uchar>()[next]) return;
      const int step = std::min(colour_step(smooth, pixel(at), pixel(next)), levels - 1);
      waiting[static_cast<std::size_t>(std::max(step, level))].emplace_back(next, source[at]);
    });
  };
  for (int at = 0; at < rows * cols; ++at) {
    if (pieces.ptr<int>()[at] == 0) continue;
    source[at] = at;
    done.ptr<uchar>()[at] = 255;
  }
  for (int at = 0; at < rows * cols; ++at) {
    if (done.ptr<uchar>()[at]) spread(at);
  }
  for (; level < levels; ++level) {
    auto& now = waiting[static_cast<std::size_t>(level)];
    for (std::size_t i = 0; i < now.size(); ++i) {  // grows meanwhile
      const auto [at, from] = now[i];
      if (done.ptr<uchar>()[at]) continue;
      done.ptr<uchar>()[at] = 255;
      source[at] = from;
      spread(at);
    }
    now = {};
  }
  return basins;
}

/// Along how many pixels two pieces meet: where depth goes on, where it makes a step, and where a colour edge
/// far from any known depth leaves it open.
struct Meeting {
  int open = 0, steps = 0, unclear = 0;
  int all() const { return open + steps + unclear; }
  double open_share() const { return static_cast<double>(open) / std::max(open + steps, 1); }
  double step_share() const { return static_cast<double>(steps) / std::max(all(), 1); }
  void add(const Meeting& other) {
    open += other.open;
    steps += other.steps;
    unclear += other.unclear;
  }
};
struct Meetings : std::map<std::pair<int, int>, Meeting> {
  std::vector<int> perimeter_px;  // of each piece grown over the pixels of unknown depth
};

Meetings meetings_of(const Basins& basins, const cv::Mat& pieces, int count, const cv::Mat& residual_px,
                     const cv::Mat& smooth, double noise) {
  const double edge = std::max(4.0, 4 * noise);
  constexpr double step_px = 0.6, slope = 0.15, reach_px = 6;
  Meetings meetings;
  meetings.perimeter_px.resize(static_cast<std::size_t>(count) + 1);
  const auto pixel = [&](int at) { return cv::Point(at % pieces.cols, at / pieces.cols); };
  const auto look = [&](int p, int q) {
    const int a = basins.piece(pieces, p), b = basins.piece(pieces, q);
    if (a == b) return;
    ++meetings.perimeter_px[static_cast<std::size_t>(a)];
    ++meetings.perimeter_px[static_cast<std::size_t>(b)];
    if (a == 0 || b == 0) return;
    Meeting& meeting = meetings[{std::min(a, b), std::max(a, b)}];
    const cv::Point from_p = pixel(basins.source.ptr<int>()[p]), from_q = pixel(basins.source.ptr<int>()[q]);
    const double gap_px = cv::norm(from_p - from_q);
    const double step = std::abs(residual_px.at<float>(from_p) - residual_px.at<float>(from_q));
    if (step > step_px + slope * gap_px) {
      ++meeting.steps;
    } else if (gap_px > reach_px && colour_step(smooth, pixel(p), pixel(q)) > edge) {
      ++meeting.unclear;
    } else {
      ++meeting.open;
    }
  };
  const int pixels = pieces.rows * pieces.cols;
  for (int at = 0; at < pixels; ++at) {
    if ((at + 1) % pieces.cols != 0) look(at, at + 1);
    if (at + pieces.cols < pixels) look(at, at + pieces.cols);
  }
  return meetings;
}

/// What is known of a piece, or of several joined, from right above (m).
struct Footprint {
  int pixels = 0;
  int group = 0;                  // of footprints that nearly touch
  bool too_large = false;         // for an object, together with its neighbours
  float foot = 0, top = 0;        // its lowest and highest point over the table
  std::vector<cv::Point2f> some;  // of its points
  std::vector<cv::Point2f> hull;  // convex, of nearly all of them
  void add(const Footprint& other) {
    foot = pixels == 0 ? other.foot : std::min(foot, other.foot);
    top = std::max(top, other.top);
    too_large |= other.too_large;
    pixels += other.pixels;
    some.insert(some.end(), other.some.begin(), other.some.end());
    std::vector<cv::Point2f> corners = hull;
    corners.insert(corners.end(), other.hull.begin(), other.hull.end());
    if (!corners.empty()) cv::convexHull(corners, hull);
  }
  double longest() const {
    const cv::RotatedRect box = cv::minAreaRect(hull);
    return std::max(box.size.width, box.size.height);
  }
  /// The share of it that lies over the other or right beside it.
  double share_over(const Footprint& other) const {
    constexpr double beside_m = 0.005;
    const auto over = std::count_if(some.begin(), some.end(), [&](const cv::Point2f& at) {
      return cv::pointPolygonTest(other.hull, at, true) > -beside_m;
    });
    return static_cast<double>(over) / static_cast<double>(some.size());
  }
};

std::vector<Footprint> footprints_of(const cv::Mat& pieces, int count, const cv::Mat& points_m,
                                     double cell_m) {
  constexpr int near_cells = 1, most_cells = 2000;
  constexpr std::size_t some = 50;
  std::vector<std::vector<cv::Point2f>> points(static_cast<std::size_t>(count) + 1);
  std::vector<std::vector<float>> heights(points.size());
  cv::Point2f low(1e9F, 1e9F), high = -low;
  for (int v = 0; v < pieces.rows; ++v) {
    for (int u = 0; u < pieces.cols; ++u) {
      const int piece = pieces.at<int>(v, u);
      if (piece == 0) continue;
      const auto& point = points_m.at<cv::Point3f>(v, u);
      const cv::Point2f at(point.x, point.y);
      points[static_cast<std::size_t>(piece)].push_back(at);
      heights[static_cast<std::size_t>(piece)].push_back(point.z);
      low = {std::min(low.x, at.x), std::min(low.y, at.y)};
      high = {std::max(high.x, at.x), std::max(high.y, at.y)};
    }
  }
  cv::Mat counts = cv::Mat::zeros(std::min(most_cells, cvFloor((high.y - low.y) / cell_m) + 1),
                                  std::min(most_cells, cvFloor((high.x - low.x) / cell_m) + 1), CV_32SC1);
  const auto cell_of = [&](const cv::Point2f& at) {
    return cv::Point(std::min(counts.cols - 1, cvFloor((at.x - low.x) / cell_m)),
                     std::min(counts.rows - 1, cvFloor((at.y - low.y) / cell_m)));
  };
  for (const auto& piece : points) {
    for (const cv::Point2f& at : piece) ++counts.at<int>(cell_of(at));
  }
  cv::Mat groups;
  cv::connectedComponents(grown(counts >= 1, near_cells), groups, 8, CV_32S);
  std::vector<Footprint> footprints(points.size());
  for (std::size_t i = 1; i < points.size(); ++i) {
    Footprint& footprint = footprints[i];
    footprint.pixels = static_cast<int>(points[i].size());
    footprint.foot = quantile(heights[i], 0.05);
    footprint.top = quantile(heights[i], 0.95);
    std::map<int, int> votes;
    std::vector<cv::Point2f> inner;
    for (const cv::Point2f& at : points[i]) {
      ++votes[groups.at<int>(cell_of(at))];
      if (counts.at<int>(cell_of(at)) >= 2) inner.push_back(at);
    }
    const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
    footprint.group = std::max_element(votes.begin(), votes.end(), fewer)->first;
    cv::convexHull(inner.empty() ? points[i] : inner, footprint.hull);
    for (std::size_t k = 0; k < points[i].size(); k += points[i].size() / some + 1) {
      footprint.some.push_back(points[i][k]);
    }
  }
  return footprints;
}

/// The pieces of a scene as they are joined.
class Joining {
 public:
  Joining(Meetings meetings, std::vector<Footprint> footprints, double max_extent_m)
      : sets_(static_cast<int>(footprints.size())),
        meetings_(std::move(meetings)),
        footprints_(std::move(footprints)),
        max_extent_m_(max_extent_m) {
    for (const auto& [pair, meeting] : meetings_) openness_[pair] = openness(pair, meeting);
  }

  /// Joins the two that belong together most surely, and again, until no two do.
  void run() {
    for (int a = 1; a < static_cast<int>(footprints_.size()); ++a) {
      for (int b = a + 1; b < static_cast<int>(footprints_.size()); ++b) {
        if (hovers(a) != hovers(b) && footprint(a).group == footprint(b).group) {
          const Pair pair(a, b);
          openness_[pair] = openness(pair, meetings_[pair]);
        }
      }
    }
    while (true) {
      const auto best = std::max_element(openness_.begin(), openness_.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
      if (best == openness_.end() || best->second <= 0) return;
      join(best->first.first, best->first.second);
    }
  }

  /// The piece that stands for all that it was joined with; 0 for a mere rim of another, or a part of a wall.
  int object_of(int piece) {
    const int root = sets_.root(piece);
    return footprint(root).too_large || is_rim(root) ? 0 : root;
  }

 private:
  using Pair = std::pair<int, int>;

  Footprint& footprint(int piece) { return footprints_[static_cast<std::size_t>(piece)]; }
  int& perimeter_px(int piece) { return meetings_.perimeter_px[static_cast<std::size_t>(piece)]; }

  /// Does nothing of it reach down to the table?
  bool hovers(int piece) {
    constexpr float least_m = 0.02F;
    return footprint(piece).foot > least_m;
  }

  /// Of a mug or bowl the inner side is seen over the near rim: as high as that, and no longer.
  static bool is_wall_of_vessel(const Footprint& a, const Footprint& b) {
    constexpr double most_longer = 1.2, most_higher = 0.15;
    if (std::abs(a.top - b.top) > most_higher * std::max(a.top, b.top)) return false;
    Footprint both = a;
    both.add(b);
    return both.longest() <= most_longer * std::max(a.longest(), b.longest());
  }

  /// How surely two pieces are one, 0 if they are not. What lies over another piece belongs to it unless
  /// there is a step between them, and even then if nothing else holds it: an object does not hover.
  double openness(const Pair& pair, const Meeting& meeting) {
    constexpr int least_px = 4;
    constexpr double least_open = 0.5, most_steps = 0.5, least_over = 0.7, least_held = 0.5,
                     wall_of_extent = 1.5;
    const Footprint &a = footprint(pair.first), &b = footprint(pair.second);
    if (a.group != b.group) return 0;
    double result = 0;
    if (meeting.open >= least_px && meeting.open_share() >= least_open) {
      result = 1 + meeting.open_share();
    } else if (meeting.open + meeting.unclear >= least_px && meeting.step_share() < most_steps) {
      const double over = a.pixels < b.pixels ? a.share_over(b) : b.share_over(a);
      if (over >= least_over) result = over;
    } else if (hovers(pair.first) != hovers(pair.second)) {
      const double over = std::max(a.share_over(b), b.share_over(a));
      if (over >= least_held) {
        result = over;
      } else if (meeting.all() >= least_px && is_wall_of_vessel(a, b)) {
        result = least_held;
      }
    }
    if (result > 0) {
      Footprint both = a;
      both.add(b);
      if (both.longest() > max_extent_m_) {
        // A wall may be cut anywhere, and none of its pieces is an object.
        const bool wall = result > 1 && both.longest() > wall_of_extent * max_extent_m_;
        if (wall) footprint(pair.first).too_large = footprint(pair.second).too_large = true;
        result = 0;
      }
    }
    return result;
  }

  void join(int a, int b) {
    sets_.join(a, b);
    const int root = sets_.root(a), gone = root == a ? b : a;
    footprint(root).add(footprint(gone));
    perimeter_px(root) += perimeter_px(gone) - 2 * meetings_[{a, b}].all();
    openness_.erase({a, b});
    meetings_.erase({a, b});
    // Whatever met one of the two meets both now.
    std::vector<std::pair<Pair, Meeting>> moved;
    for (auto it = meetings_.begin(); it != meetings_.end();) {
      const auto [x, y] = it->first;
      if (x != gone && y != gone) {
        ++it;
        continue;
      }
      const int other = x == gone ? y : x;
      moved.push_back({{std::min(root, other), std::max(root, other)}, it->second});
      openness_.erase(it->first);
      it = meetings_.erase(it);
    }
    for (const auto& [pair, meeting] : moved) meetings_[pair].add(meeting);
    for (const auto& [pair, meeting] : meetings_) {
      if (pair.first == root || pair.second == root) openness_[pair] = openness(pair, meeting);
    }
  }

  /// A thin band along something larger has a depth between that and the table: it is no object.
  bool is_rim(int piece) {
    constexpr double least_contact = 0.35, most_pixels = 0.25, widest_px = 6;
    for (const auto& [pair, meeting] : meetings_) {
      if (pair.first != piece && pair.second != piece) continue;
      const int other = pair.first == piece ? pair.second : pair.first;
      const double width_px = 2.0 * footprint(piece).pixels / std::max(perimeter_px(piece), 1);
      if (meeting.all() >= least_contact * perimeter_px(piece) && width_px <= widest_px &&
          footprint(piece).pixels <= most_pixels * footprint(other).pixels) {
        return true;
      }
    }
    return false;
  }

  DisjointSets sets_;
  Meetings meetings_;
  std::vector<Footprint> footprints_;
  std::map<Pair, double> openness_;
  double max_extent_m_;
};

}  // namespace

cv::Mat raised_objects(const cv::Mat& image, const cv::Mat& raised, const cv::Mat& ground,
                       const cv::Mat& residual_px, const cv::Mat& points_m,
                       const SegmentationOptions& options, int& objects) {
  int count = 0;
  cv::Mat pieces = pieces_without_steps(raised, residual_px, count);
  objects = 0;
  if (count == 0) return pieces;
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, {5, 5}, 1);
  const Basins basins = flood(pieces, smooth, ground & ~(pieces > 0));
  Joining joining(meetings_of(basins, pieces, count, residual_px, smooth, noise_sigma(grey(image)) / 2),
                  footprints_of(pieces, count, points_m, options.cell_m), options.max_extent_m);
  joining.run();
  std::vector<int> names(static_cast<std::size_t>(count) + 1), numbers(names.size());
  for (int piece = 1; piece <= count; ++piece) {
    const int object = joining.object_of(piece);
    if (object == 0) continue;
    int& number = numbers[static_cast<std::size_t>(object)];
    if (number == 0) number = ++objects;
    names[static_cast<std::size_t>(piece)] = number;
  }
  for (int v = 0; v < pieces.rows; ++v) {
    for (int u = 0; u < pieces.cols; ++u) {
      pieces.at<int>(v, u) = names[static_cast<std::size_t>(pieces.at<int>(v, u))];
    }
  }
  return pieces;
}

}  // namespace graspctx::detail
