#include "detail/strange_colours.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "detail/masks.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/quantile.hpp"

namespace graspctx::detail {

namespace {

constexpr double highest_px = 4;     // over the plane, of what is low
constexpr double on_table_px = 0.3;  // of residual
constexpr int strangest = 8;         // cells from the common colours

/// Cells of Lab that are coarser than the noise of a camera.
struct ColourCells {
  static constexpr int lightness_levels = 8, chroma_levels = 2;
  static constexpr int lightness_cells = 256 / lightness_levels, chroma_cells = 256 / chroma_levels;
  static constexpr int count = lightness_cells * chroma_cells * chroma_cells;
  static int of(int lightness, int a, int b) { return (lightness * chroma_cells + a) * chroma_cells + b; }
  static int of(const cv::Vec3b& lab) {
    return of(lab[0] / lightness_levels, lab[1] / chroma_levels, lab[2] / chroma_levels);
  }
};

cv::Mat smooth_lab(const cv::Mat& image) {
  cv::Mat lab;
  cv::GaussianBlur(image, lab, {3, 3}, 0);
  if (image.channels() == 1) cv::cvtColor(lab, lab, cv::COLOR_GRAY2BGR);
  cv::cvtColor(lab, lab, cv::COLOR_BGR2Lab);
  return lab;
}

/// How many pixels of the region have each colour.
std::vector<int> colour_counts(const cv::Mat& lab, const cv::Mat& region) {
  std::vector<int> counts(ColourCells::count);
  for (int v = 0; v < lab.rows; ++v) {
    for (int u = 0; u < lab.cols; ++u) {
      if (region.at<uchar>(v, u))
        ++counts[static_cast<std::size_t>(ColourCells::of(lab.at<cv::Vec3b>(v, u)))];
    }
  }
  return counts;
}

/// The same colours in less light: Lab is nearly proportional to it, as image values are.
void add_shadows(cv::Mat& common) {
  constexpr double deepest = 0.3, step = 0.05;
  const cv::Mat lit = common.clone();
  const auto scaled = [](int chroma, double light) {
    constexpr int grey = ColourCells::chroma_cells / 2;
    return grey + cvRound(light * (chroma - grey));
  };
  for (int at = 0; at < ColourCells::count; ++at) {
    if (!lit.ptr<uchar>()[at]) continue;
    const int b = at % ColourCells::chroma_cells,
              a = at / ColourCells::chroma_cells % ColourCells::chroma_cells;
    const int lightness = at / ColourCells::chroma_cells / ColourCells::chroma_cells;
    for (double light = deepest; light < 1; light += step) {
      common.ptr<uchar>()[ColourCells::of(cvRound(light * lightness), scaled(a, light), scaled(b, light))] =
          255;
    }
  }
}

/// The number of pixels of the rarest of the colours that together make up nearly all.
int least_of_common(const std::vector<int>& counts) {
  constexpr double common_share = 0.97;
  std::vector<int> falling;
  double all = 0;
  for (const int count : counts) {
    if (count > 0) falling.push_back(count);
    all += count;
  }
  std::sort(falling.begin(), falling.end(), std::greater<>());
  int least = std::numeric_limits<int>::max();
  double sum = 0;
  for (const int count : falling) {
    least = count;
    sum += count;
    if (sum >= common_share * all) break;
  }
  return least;
}

/// For each colour how many cells it is from the common ones and those in their shadows, up to a limit.
cv::Mat strangeness_of_colours(const std::vector<int>& counts) {
  // A row for each lightness and a, a column for each b: one dilation grows by a and b, another by lightness.
  const cv::Mat rows(ColourCells::lightness_cells * ColourCells::chroma_cells, ColourCells::chroma_cells,
                     CV_32SC1, const_cast<int*>(counts.data()));
  cv::Mat near = rows >= least_of_common(counts);
  add_shadows(near);
  cv::Mat strangeness = cv::Mat::zeros(near.size(), CV_8UC1);
  const cv::Mat by_chroma = cv::Mat::ones(3, 3, CV_8U);
  constexpr int next_lightness = ColourCells::chroma_cells;
  for (int cells = 0; cells < strangest; ++cells) {
    strangeness += (near == 0) & 1;
    cv::dilate(near, near, by_chroma);
    const cv::Mat before = near.clone();
    const int kept = near.rows - next_lightness;
    near.rowRange(next_lightness, near.rows) |= before.rowRange(0, kept);
    near.rowRange(0, kept) |= before.rowRange(next_lightness, near.rows);
  }
  return strangeness;
}

/// The convex hull of what lies on the plane, as the left view shows it.
cv::Mat table_in_view(const TablePlane& plane, const TableFrame& frame, const StereoCamera& camera,
                      const cv::Size& size) {
  std::vector<cv::Point> corners;
  for (const cv::Point2f& at : frame.hull) {
    const Eigen::Vector3d point =
        double(at.x) * frame.right + double(at.y) * frame.nearer - plane.offset_m * plane.normal;
    const Eigen::Vector2d pixel = camera.project(point);
    corners.emplace_back(cvRound(pixel.x()), cvRound(pixel.y()));
  }
  cv::Mat table = cv::Mat::zeros(size, CV_8UC1);
  cv::fillConvexPoly(table, corners, 255);
  return table;
}

/// How much two maps of strangeness differ over pixels, if the second one is moved by a disparity. They show
/// the outline of what is strange, and nothing of the table's own texture.
double difference(const cv::Mat& left, const cv::Mat& right, const std::vector<cv::Point>& pixels,
                  double disparity_px) {
  const int whole = cvFloor(-disparity_px);
  const auto part = static_cast<float>(-disparity_px - whole);
  double sum = 0;
  for (const cv::Point& at : pixels) {
    const int u = std::clamp(at.x + whole, 0, right.cols - 2);
    const float* there = right.ptr<float>(at.y) + u;
    const float d = left.at<float>(at) - (there[0] + part * (there[1] - there[0]));
    sum += d * d;
  }
  return sum;
}

/// The residual of the table around a piece: the plane may be a little wrong there.
double residual_of_table(const cv::Mat& residual_px, const cv::Mat& strangeness, const cv::Rect& box) {
  constexpr int reach_px = 30;
  constexpr std::size_t least_px = 100;
  constexpr float most_px = 0.5F;
  const cv::Rect around =
      cv::Rect(box.x - reach_px, box.y - reach_px, box.width + 2 * reach_px, box.height + 2 * reach_px) &
      cv::Rect({0, 0}, residual_px.size());
  std::vector<float> residuals;
  for (int v = around.y; v < around.br().y; ++v) {
    for (int u = around.x; u < around.br().x; ++u) {
      const float r = residual_px.at<float>(v, u);
      if (strangeness.at<uchar>(v, u) == 0 && std::abs(r) < most_px) residuals.push_back(r);
    }
  }
  return residuals.size() < least_px ? 0 : median(std::move(residuals));
}

/// The residual of a low object that explains the pixels best; 0 if that is not surely better than the plane.
double residual_of_piece(const cv::Mat& left, const cv::Mat& right, const std::vector<cv::Point>& pixels,
                         double table_px, double stretch) {
  constexpr double coarse_px = 0.5, fine_px = 0.0625, least_px = 0.15, least_ratio = 1.25;
  double best_px = 0, best = std::numeric_limits<double>::infinity();
  const auto look = [&](double first_px, double last_px, double step_px) {
    for (double r = first_px; r <= last_px; r += step_px) {
      const double misfit = difference(left, right, pixels, (table_px + r) / stretch);
      if (misfit < best) {
        best = misfit;
        best_px = r;
      }
    }
  };
  look(-highest_px / 2, highest_px, coarse_px);
  const double around_px = best_px;
  look(around_px - coarse_px, around_px + coarse_px, fine_px);
  const double on_table = difference(left, right, pixels, table_px / stretch);
  if (best_px < least_px || best_px >= highest_px || on_table < least_ratio * best) return 0;
  return table_px + best_px;
}

cv::Mat strangeness_in_view(const cv::Mat& lab, const cv::Mat& strangeness_of) {
  cv::Mat strangeness(lab.size(), CV_8UC1);
  for (int v = 0; v < lab.rows; ++v) {
    const auto* colour = lab.ptr<cv::Vec3b>(v);
    auto* to = strangeness.ptr<uchar>(v);
    for (int u = 0; u < lab.cols; ++u) to[u] = strangeness_of.ptr<uchar>()[ColourCells::of(colour[u])];
  }
  return strangeness;
}

cv::Mat smooth_outlines(const cv::Mat& strangeness) {
  cv::Mat smooth;
  strangeness.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {3, 3}, 0);
  return smooth;
}

/// How strange the colours of both views are on a table.
struct StrangeViews {
  cv::Mat left;                       // CV_8UC1, in cells from the table's colours
  cv::Mat smooth_left, smooth_right;  // CV_32FC1, the right one over the plane
};

StrangeViews strange_views(const cv::Mat& left, const TablePlane& plane, const cv::Mat& table,
                           const Relief& relief) {
  constexpr double surely_raised_px = 1;
  const cv::Mat raised = grown(relief.residual_px > surely_raised_px, 8);
  const cv::Mat lab = smooth_lab(left);
  const cv::Mat strangeness_of = strangeness_of_colours(colour_counts(lab, table & ~raised));
  cv::Mat right;
  right_view_over_plane(relief.right, plane, cv::Mat::zeros(left.size(), CV_32FC1)).convertTo(right, CV_8U);
  StrangeViews views;
  views.left = strangeness_in_view(lab, strangeness_of);
  views.smooth_left = smooth_outlines(views.left);
  views.smooth_right = smooth_outlines(strangeness_in_view(smooth_lab(right), strangeness_of));
  return views;
}

/// Is a piece low, and unknown to the matcher in part? What is high enough the matcher knows better.
bool is_low(const cv::Mat& piece, const cv::Mat& residual_px) {
  constexpr double most_known = 0.7, most_high = 0.05;
  const int known = cv::countNonZero(piece & (residual_px > on_table_px));
  const int high = cv::countNonZero(piece & (residual_px > highest_px));
  return known <= most_known * cv::countNonZero(piece) && high <= most_high * known;
}

}  // namespace

std::vector<cv::Mat> raise_strange_colours(const RectifiedPair& pair, const TablePlane& plane,
                                           const TableFrame& frame, const StereoCamera& camera,
                                           Relief& relief) {
  constexpr int least_px = 40, least_strange = 2, margin_px = 3, rim_px = 8;
  if (frame.hull.size() < 3) return {};
  const cv::Size size = pair.left.size();
  const cv::Mat table = table_in_view(plane, frame, camera, size) & relief.inside;
  const StrangeViews views = strange_views(pair.left, plane, table, relief);
  // What shows behind the table's edge has another colour, too.
  const cv::Mat rim = table & ~shrunk(table, rim_px);
  std::vector<cv::Mat> found;
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats((views.left >= least_strange) & table, labels, stats,
                                                     centres, 8, CV_32S);
  for (int label = 1; label < count; ++label) {
    const int* of = stats.ptr<int>(label);
    if (of[cv::CC_STAT_AREA] < least_px) continue;
    const cv::Rect box =
        cv::Rect(of[cv::CC_STAT_LEFT] - margin_px, of[cv::CC_STAT_TOP] - margin_px,
                 of[cv::CC_STAT_WIDTH] + 2 * margin_px, of[cv::CC_STAT_HEIGHT] + 2 * margin_px) &
        cv::Rect({0, 0}, size);
    const cv::Mat piece = labels(box) == label;
    cv::Mat residual_px = relief.residual_px(box);
    if (cv::countNonZero(piece & rim(box)) > 0 || !is_low(piece, residual_px)) continue;
    std::vector<cv::Point> around = where(grown(piece, margin_px));
    for (cv::Point& at : around) at += box.tl();
    const double table_px = residual_of_table(relief.residual_px, views.left, box);
    const double of_piece_px =
        residual_of_piece(views.smooth_left, views.smooth_right, around, table_px, 1 - plane.alpha);
    if (of_piece_px <= 0) continue;
    residual_px.setTo(of_piece_px, piece & ~(residual_px > on_table_px));
    found.push_back(cv::Mat::zeros(size, CV_8UC1));
    found.back()(box).setTo(255, piece);
  }
  return found;
}

}  // namespace graspctx::detail
