#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "detail/canvas.hpp"
#include "detail/check.hpp"
#include "detail/number_text.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/quantile.hpp"
#include "graspctx/io/picture.hpp"

namespace graspctx {

namespace {

using namespace detail;

const cv::Scalar paper(250, 250, 250), ink(40, 40, 40), grid_colour(90, 230, 250), alarm(40, 90, 255),
    below_table(190, 190, 190);  // BGR

/// Sizes that all panels share.
struct Layout {
  double scale = 1;    // of the image
  double text_px = 0;  // a capital letter
  int stroke_px = 1;
  int panel_width_px = 0, panel_height_px = 0, caption_px = 0, footer_px = 0, gap_px = 0;

  Layout(const cv::Size& image, int panel_px)
      : scale(static_cast<double>(panel_px) / std::max(image.width, image.height)),
        text_px(panel_px / 46.0),
        stroke_px(std::max(1, cvRound(panel_px / 640.0))),
        panel_width_px(std::max(cvRound(scale * image.width), panel_px * 2 / 3)),
        panel_height_px(std::max(cvRound(scale * image.height), panel_px / 4)),
        caption_px(cvRound(2.4 * text_px)),
        footer_px(cvRound(4 * text_px)),
        gap_px(cvRound(text_px)) {}
  cv::Size cell_px() const { return {panel_width_px, caption_px + panel_height_px + footer_px}; }
  int line_px() const { return cvRound(1.8 * text_px); }
};

void write(cv::Mat& picture, const std::string& text, const cv::Point& baseline_left, const Layout& layout,
           const cv::Scalar& colour = ink) {
  draw_text(picture, text, baseline_left, layout.text_px, colour, layout.stroke_px);
}

/// Text in lines no longer than `width_px`, broken between words.
std::vector<std::string> wrapped(const std::string& text, int width_px, const Layout& layout) {
  std::vector<std::string> lines;
  std::string line;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::string longer = line.empty() ? word : line + " " + word;
    if (!line.empty() && text_size(longer, layout.text_px, layout.stroke_px).width > width_px) {
      lines.push_back(line);
      line = word;
    } else {
      line = longer;
    }
    begin = end + 1;
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

// ---- Numbers as colours -----------------------------------------------------------------------------------

/// How values are told by colours. A square root shows low objects beside tall ones.
struct ValueScale {
  double low = 0, high = 1;
  bool square_root = false;
  cv::ColormapTypes map = cv::COLORMAP_VIRIDIS;  // as bright as the value is large

  double share(double value) const {
    const double linear = std::clamp((value - low) / (high - low), 0.0, 1.0);
    return square_root ? std::sqrt(linear) : linear;
  }
  cv::Mat colours() const {
    cv::Mat shares(1, 256, CV_8UC1), colours;
    for (int i = 0; i < 256; ++i) shares.at<uchar>(i) = static_cast<uchar>(i);
    cv::applyColorMap(shares, colours, map);
    return colours;
  }
};

/// Of 1, 2, 5, 10, 20, 50 … times a power of ten the least that is not below `value`.
double round_up(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= value * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::vector<float> known_values(const cv::Mat& values, const cv::Mat& where = {}) {
  std::vector<float> known;
  for (int v = 0; v < values.rows; ++v) {
    for (int u = 0; u < values.cols; ++u) {
      const float value = values.at<float>(v, u);
      if (std::isfinite(value) && (where.empty() || where.at<uchar>(v, u))) known.push_back(value);
    }
  }
  return known;
}

/// Where nothing is known: hatched, so that it looks like no value.
cv::Vec3b hatching(int u, int v, const Layout& layout) {
  const int period = 6 * layout.stroke_px;
  const uchar level = (u + v) % period < layout.stroke_px ? 110 : 50;
  return {level, level, level};
}

/// Values (CV_32FC1 of the image's size) in colours; `sure`: what is known there, too, is no guess.
cv::Mat coloured(const cv::Mat& values, const cv::Mat& sure, const ValueScale& scale, const Layout& layout) {
  const cv::Size size(std::max(1, cvRound(layout.scale * values.cols)),
                      std::max(1, cvRound(layout.scale * values.rows)));
  cv::Mat scaled, scaled_sure, picture(size, CV_8UC3);
  cv::resize(values, scaled, size, 0, 0, cv::INTER_NEAREST);
  cv::resize(sure, scaled_sure, size, 0, 0, cv::INTER_NEAREST);
  const cv::Mat colours = scale.colours();
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const float value = scaled.at<float>(v, u);
      cv::Vec3b& pixel = picture.at<cv::Vec3b>(v, u);
      if (!std::isfinite(value)) {
        pixel = hatching(u, v, layout);
        continue;
      }
      pixel = colours.at<cv::Vec3b>(cvRound(255 * scale.share(value)));
      if (!std::isfinite(scaled_sure.at<float>(v, u))) pixel = 0.45 * pixel;
    }
  }
  return picture;
}

struct Tick {
  double value;
  std::string text;
};

/// A bar of the scale's colours with its ticks, to stand below a panel.
void draw_scale(cv::Mat& footer, const ValueScale& scale, const std::vector<Tick>& ticks,
                const Layout& layout) {
  const int margin = cvRound(layout.text_px), stroke = layout.stroke_px;
  const cv::Rect bar(margin, cvRound(0.4 * layout.text_px), footer.cols - 2 * margin,
                     cvRound(layout.text_px));
  cv::resize(scale.colours(), footer(bar), bar.size(), 0, 0, cv::INTER_LINEAR);
  cv::rectangle(footer, bar, ink, stroke);
  int free_from = 0;
  for (const Tick& tick : ticks) {
    const int at = bar.x + cvRound(scale.share(tick.value) * (bar.width - 1));
    const cv::Size size = text_size(tick.text, layout.text_px, stroke);
    const int left = std::clamp(at - size.width / 2, 0, std::max(0, footer.cols - size.width));
    if (left < free_from) continue;
    free_from = left + size.width + cvRound(layout.text_px);
    cv::line(footer, {at, bar.y}, {at, bar.br().y + margin / 3}, ink, stroke);
    write(footer, tick.text, {left, bar.br().y + cvRound(1.6 * layout.text_px)}, layout);
  }
}

std::vector<Tick> even_ticks(const ValueScale& scale, const StereoCamera& camera) {
  std::vector<Tick> ticks;
  const double step = round_up((scale.high - scale.low) / 4);
  for (double value = std::ceil(scale.low / step) * step; value <= scale.high; value += step) {
    const double depth_m = camera.depth_m(value);
    std::string text = decimal_text(value, step < 1 ? 1 : 0) + " px";
    if (std::isfinite(depth_m)) text += ": " + decimal_text(depth_m, 2) + " m";
    ticks.push_back({value, std::move(text)});
  }
  return ticks;
}

std::vector<Tick> height_ticks(const ValueScale& scale) {
  std::vector<Tick> ticks{{0, "0"}};
  for (double value = 0.005; value <= scale.high; value = round_up(1.01 * value)) {
    ticks.push_back({value, number_text(std::round(1000 * value) / 1000) + " m"});
  }
  return ticks;
}

// ---- The panels -------------------------------------------------------------------------------------------

/// A panel with what stands above and below it.
struct Panel {
  cv::Mat picture;
  std::string caption;
  std::string remark;  // below, unless there is a scale
  std::optional<ValueScale> scale;
  std::vector<Tick> ticks;
};

/// What the panels show.
struct Scene {
  const cv::Mat& left;
  const Disparity& disparity;
  const StereoCamera& camera;
  const SegmentationOptions& options;
  const Segmentation& shown;
  const TablePlane* table;  // of the level that is shown, or of another; null without one
  const cv::Mat& heights_m;
  const Layout& layout;
};

/// The image in grey and dark, for what is drawn on it to be seen.
Canvas dimmed(const Scene& scene, double brightness) {
  cv::Mat grey_image = scene.left, darker;
  if (scene.left.channels() == 3) cv::cvtColor(scene.left, grey_image, cv::COLOR_BGR2GRAY);
  grey_image.convertTo(darker, CV_8U, brightness);
  return canvas_of(darker, scene.layout.scale);
}

void draw_message(cv::Mat& picture, const std::string& text, const Layout& layout) {
  const cv::Size size = text_size(text, layout.text_px, layout.stroke_px);
  const cv::Point at((picture.cols - size.width) / 2, (picture.rows + size.height) / 2);
  draw_text(picture, text, at, layout.text_px, black, 3 * layout.stroke_px);
  draw_text(picture, text, at, layout.text_px, white, layout.stroke_px);
}

cv::Mat segment_of(const Segmentation& segmentation, const ObjectHypothesis& object, const cv::Size& size) {
  return scaled_mask(segmentation.instance_ids == object.id, size);
}

/// The sides of the image that cut an object off.
void draw_cut_sides(Canvas& canvas, const cv::Mat& segment) {
  const int width = 4 * canvas.stroke_px;
  const cv::Rect whole({0, 0}, segment.size());
  const std::array<cv::Rect, 4> sides{cv::Rect(0, 0, whole.width, width),
                                      {0, whole.height - width, whole.width, width},
                                      {0, 0, width, whole.height},
                                      {whole.width - width, 0, width, whole.height}};
  for (const cv::Rect& side : sides) {
    const cv::Rect inside = side & whole;
    canvas.picture(inside).setTo(alarm, segment(inside));
  }
}

/// Where the caller looks: a cross and a box.
void draw_gaze(Canvas& canvas, const SegmentationOptions& options) {
  for (const auto& [colour, width] : {std::pair(black, 4), std::pair(white, 2)}) {
    const int width_px = width * canvas.stroke_px;
    if (options.fixation_px) {
      const Eigen::Vector2d at = canvas.from_image(*options.fixation_px);
      for (const Eigen::Vector2d& arm : {Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)}) {
        draw_line(canvas.picture, at - 12 * canvas.stroke_px * arm, at + 12 * canvas.stroke_px * arm, colour,
                  width_px);
      }
    }
    if (options.roi_px) {
      const cv::Rect2d box(*options.roi_px);
      const Eigen::Vector2d first = canvas.from_image({box.x, box.y}),
                            last = canvas.from_image({box.br().x - 1, box.br().y - 1});
      draw_line(canvas.picture, first, {last.x(), first.y()}, colour, width_px);
      draw_line(canvas.picture, {last.x(), first.y()}, last, colour, width_px);
      draw_line(canvas.picture, last, {first.x(), last.y()}, colour, width_px);
      draw_line(canvas.picture, {first.x(), last.y()}, first, colour, width_px);
    }
  }
}

std::vector<std::string> marks_of(const ObjectHypothesis& object) {
  std::vector<std::string> marks;
  if (object.touches_border) marks.emplace_back("cut by the border");
  if (object.leaves_table) marks.emplace_back("leaves the table");
  return marks;
}

/// Length, width and height in centimetres.
std::string size_text(const Eigen::Vector3d& size_m) {
  return decimal_text(100 * size_m.x(), 1) + " x " + decimal_text(100 * size_m.y(), 1) + " x " +
         decimal_text(100 * size_m.z(), 1) + " cm";
}

Panel hypotheses_panel(const Scene& scene) {
  Canvas canvas = canvas_of(scene.left, scene.layout.scale);
  canvas.stroke_px = scene.layout.stroke_px;
  std::vector<Tint> segments;
  for (const ObjectHypothesis& object : scene.shown.objects) {
    segments.push_back(
        {segment_of(scene.shown, object, canvas.picture.size()), segment_colour(segments.size())});
  }
  draw_segments(canvas, segments, 0.25, 2 * canvas.stroke_px);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (scene.shown.objects[i].touches_border) draw_cut_sides(canvas, segments[i].mask);
  }
  draw_gaze(canvas, scene.options);
  canvas.occupied.setTo(hides_hand, canvas.occupied);  // labels keep off the objects, if there is room
  std::vector<cv::Rect> placed;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const ObjectHypothesis& object = scene.shown.objects[i];
    std::vector<std::string> lines{std::to_string(object.id)};
    if (object.size_m) lines[0] += ": " + size_text(*object.size_m);
    for (const std::string& mark : marks_of(object)) lines.push_back(mark);
    draw_label(canvas, canvas.from_image(object.centroid_px),
               {std::move(lines), scene.layout.text_px, segments[i].colour, white}, placed);
  }
  const std::string level = name_of(scene.options.cues);
  return {canvas.picture,
          "hypotheses, the most salient is 1",
          "cue level " + level + (scene.options.fixation_px ? ", fixated at the cross" : "") +
              (scene.options.roi_px ? ", in the box only" : "") +
              (scene.shown.table ? "; size: length x width x height" : ""),
          {},
          {}};
}

Panel disparity_panel(const Scene& scene) {
  ValueScale scale;
  std::vector<float> values = known_values(scene.disparity.reliable);
  if (values.empty()) values = known_values(scene.disparity.dense);
  if (values.empty()) values = {0};
  scale.low = quantile(values, 0.01);
  scale.high = std::max<double>(quantile(values, 0.99), scale.low + 1);
  return {coloured(scene.disparity.dense, scene.disparity.reliable, scale, scene.layout),
          "disparity (dark: not reliable, hatched: unknown)", "", scale, even_ticks(scale, scene.camera)};
}

/// Where the table is seen: what lies on the plane, and between it, but nothing that stands on it.
cv::Mat seen_table(const Scene& scene) {
  constexpr double near_px = 0.5, stands_m = 0.006;
  const TablePlane& plane = *scene.table;
  cv::Mat support(scene.left.size(), CV_8UC1, cv::Scalar(0)), above = support.clone();
  for (int v = 0; v < support.rows; ++v) {
    for (int u = 0; u < support.cols; ++u) {
      const float height = scene.heights_m.at<float>(v, u);
      if (!std::isfinite(height)) continue;
      const double near_m = height_m(plane, scene.camera, u, v, plane_disparity(plane, u, v) + near_px);
      support.at<uchar>(v, u) = std::abs(height) < near_m ? 255 : 0;
      above.at<uchar>(v, u) = height > std::max(near_m, stands_m) ? 255 : 0;
    }
  }
  cv::morphologyEx(support, support, cv::MORPH_OPEN, cv::Mat::ones(5, 5, CV_8UC1));
  std::vector<cv::Point> points, hull;
  cv::findNonZero(support, points);
  cv::Mat table(support.size(), CV_8UC1, cv::Scalar(points.empty() ? 255 : 0));
  if (!points.empty()) {
    cv::convexHull(points, hull);
    cv::fillConvexPoly(table, hull, 255);
  }
  return table & ~above & ~(scene.shown.instance_ids > 0);
}

/// The part of the plane that is seen, in coordinates along the table.
struct GridFrame {
  Eigen::Vector3d origin_m, right, ahead;
  Eigen::Vector2d least_m, most_m;
  Eigen::Vector3d point(double right_m, double ahead_m) const {
    return origin_m + right_m * right + ahead_m * ahead;
  }
};

std::optional<GridFrame> grid_frame(const Scene& scene, const cv::Mat& seen) {
  constexpr double farthest_m = 5;
  const TablePlane& plane = *scene.table;
  GridFrame frame;
  frame.origin_m = -plane.offset_m * plane.normal;  // below the camera
  frame.ahead = (Eigen::Vector3d::UnitZ() - plane.normal.z() * plane.normal).normalized();
  if (!frame.ahead.allFinite() || frame.ahead.norm() < 0.5) frame.ahead = plane.normal.unitOrthogonal();
  frame.right = frame.ahead.cross(plane.normal);
  frame.least_m.setConstant(std::numeric_limits<double>::infinity());
  frame.most_m = -frame.least_m;
  for (int v = 0; v < seen.rows; v += 4) {
    for (int u = 0; u < seen.cols; u += 4) {
      if (!seen.at<uchar>(v, u)) continue;
      const Eigen::Vector3d ray = scene.camera.ray({u, v});
      const double distance_m = -plane.offset_m / plane.normal.dot(ray);
      if (!(distance_m > 0) || distance_m > farthest_m) continue;
      const Eigen::Vector3d from_origin = distance_m * ray - frame.origin_m;
      const Eigen::Vector2d at(from_origin.dot(frame.right), from_origin.dot(frame.ahead));
      frame.least_m = frame.least_m.cwiseMin(at);
      frame.most_m = frame.most_m.cwiseMax(at);
    }
  }
  if (!frame.least_m.allFinite()) return std::nullopt;
  return frame;
}

std::string camera_over_table(const TablePlane& table) {
  const double down = std::asin(std::clamp(-table.normal.z(), -1.0, 1.0)) * 180 / CV_PI;
  const double roll = std::atan2(table.normal.x(), -table.normal.y()) * 180 / CV_PI;
  return "camera " + decimal_text(table.offset_m, 3) + " m above, looks " + decimal_text(down, 1) +
         " deg down, roll " + decimal_text(roll, 1) + " deg";
}

Panel table_panel(const Scene& scene) {
  Canvas canvas = dimmed(scene, 0.6);
  if (!scene.table) {
    draw_message(canvas.picture, "no support plane", scene.layout);
    return {canvas.picture, "table plane", "", {}, {}};
  }
  const cv::Mat seen = seen_table(scene);
  const auto frame = grid_frame(scene, seen);
  std::string caption = "table plane";
  if (frame) {
    const double extent_m = (frame->most_m - frame->least_m).maxCoeff();
    const double step_m = std::max(0.05, round_up(extent_m / 30));
    Canvas lines = canvas;
    lines.picture = canvas.picture.clone();
    const Eigen::Array2d first = (frame->least_m.array() / step_m).floor() * step_m,
                         last = (frame->most_m.array() / step_m).ceil() * step_m;
    for (double r = first.x(); r <= last.x() + 1e-9; r += step_m) {
      draw_line_3d(lines, frame->point(r, first.y()), frame->point(r, last.y()), scene.camera, grid_colour,
                   scene.layout.stroke_px);
    }
    for (double a = first.y(); a <= last.y() + 1e-9; a += step_m) {
      draw_line_3d(lines, frame->point(first.x(), a), frame->point(last.x(), a), scene.camera, grid_colour,
                   scene.layout.stroke_px);
    }
    lines.picture.copyTo(canvas.picture, scaled_mask(seen, canvas.picture.size()));
    caption += ", grid of " + number_text(std::round(100 * step_m)) + " cm";
  }
  if (scene.options.table) caption += ", given";
  return {canvas.picture, caption, camera_over_table(*scene.table), {}, {}};
}

Panel heights_panel(const Scene& scene) {
  const std::string caption = "height above the table (grey: below)";
  if (!scene.table || scene.heights_m.empty()) {
    cv::Mat picture = dimmed(scene, 0.6).picture;
    draw_message(picture, "no support plane", scene.layout);
    return {picture, caption, "", {}, {}};
  }
  ValueScale scale;
  scale.map = cv::COLORMAP_PLASMA;
  scale.square_root = true;
  const std::vector<float> of_objects = known_values(scene.heights_m, scene.shown.instance_ids);
  const double top_m = of_objects.empty() ? 0.1 : quantile(of_objects, 0.99);
  scale.high = std::clamp(top_m, 0.02, scene.options.max_height_m);
  cv::Mat picture = coloured(scene.heights_m, scene.heights_m, scale, scene.layout);
  cv::Mat below;
  constexpr double noise_m = -0.01;
  cv::resize(scene.heights_m < noise_m, below, picture.size(), 0, 0, cv::INTER_NEAREST);
  picture.setTo(below_table, below);
  return {picture, caption, "", scale, height_ticks(scale)};
}

/// The colours of a level's objects: an object that the shown level has, too, has the same one there.
std::vector<std::size_t> colours_like(const Segmentation& shown, const Segmentation& other) {
  std::vector<std::size_t> colours;
  std::vector<bool> taken(shown.objects.size(), false);
  std::size_t next = shown.objects.size();
  for (const ObjectHypothesis& object : other.objects) {
    const cv::Mat mask = other.instance_ids == object.id;
    std::size_t best = shown.objects.size();
    int most_px = 0;
    for (std::size_t i = 0; i < shown.objects.size(); ++i) {
      const int common_px = cv::countNonZero(mask & (shown.instance_ids == shown.objects[i].id));
      if (!taken[i] && common_px > most_px) {
        most_px = common_px;
        best = i;
      }
    }
    const bool found = best < shown.objects.size();
    if (found) taken[best] = true;
    colours.push_back(found ? best : next++);
  }
  return colours;
}

Panel level_panel(const Scene& scene, CueLevel level, const Segmentation* segmentation) {
  static const char* const cues[] = {"zero disparity", "+ the table plane", "+ hue"};
  const std::string caption =
      std::string("level ") + name_of(level) + " (" + cues[static_cast<int>(level)] + ")";
  Canvas canvas = dimmed(scene, 0.45);
  if (!segmentation) {
    draw_message(canvas.picture, "not segmented", scene.layout);
    return {canvas.picture, caption, "", {}, {}};
  }
  const cv::Mat bright = canvas_of(scene.left, scene.layout.scale).picture;
  const std::vector<std::size_t> colours = colours_like(scene.shown, *segmentation);
  std::vector<Tint> segments;
  for (const ObjectHypothesis& object : segmentation->objects) {
    segments.push_back(
        {segment_of(*segmentation, object, bright.size()), segment_colour(colours[segments.size()])});
    bright.copyTo(canvas.picture, segments.back().mask);
  }
  draw_segments(canvas, segments, 0.35, 2 * scene.layout.stroke_px);
  const std::size_t count = segmentation->objects.size();
  std::string remark =
      count == 0 ? "no object" : std::to_string(count) + (count == 1 ? " object" : " objects");
  if (level != CueLevel::disparity && !segmentation->table) remark += ", without a support plane";
  return {canvas.picture, caption, remark, {}, {}};
}

/// The objects and the scene in numbers.
cv::Mat numbers(const Scene& scene) {
  const Layout& layout = scene.layout;
  cv::Mat cell(layout.cell_px(), CV_8UC3, paper);
  const int chip = cvRound(layout.text_px), last_baseline = cell.rows - chip;
  int baseline = cvRound(1.5 * layout.text_px);
  const auto add = [&](const std::string& text, int indent_px) {
    for (const std::string& line : wrapped(text, cell.cols - indent_px, layout)) {
      if (baseline <= last_baseline) write(cell, line, {indent_px, baseline}, layout);
      baseline += layout.line_px();
    }
  };
  const std::vector<ObjectHypothesis>& objects = scene.shown.objects;
  add(objects.empty() ? "no object" : "objects", 0);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (baseline + 4 * layout.line_px() > last_baseline) {
      add("and " + std::to_string(objects.size() - i) + " more", 0);
      break;
    }
    const cv::Rect box(0, baseline - chip, chip, chip);
    cv::rectangle(cell, box, segment_colour(i), cv::FILLED);
    cv::rectangle(cell, box, ink, layout.stroke_px);
    std::string text = std::to_string(objects[i].id);
    if (objects[i].size_m) text += "  " + size_text(*objects[i].size_m);
    if (objects[i].depth_m) text += "  " + decimal_text(*objects[i].depth_m, 3) + " m away";
    for (const std::string& mark : marks_of(objects[i])) text += ", " + mark;
    add(text, 2 * chip);
  }
  if (scene.shown.vertical_offset_px) {
    baseline += layout.line_px() / 2;
    add("rows of the views apart by " + decimal_text(std::abs(*scene.shown.vertical_offset_px), 1) + " px",
        0);
  }
  for (const std::string& warning : scene.shown.warnings) {
    baseline += layout.line_px() / 2;
    add("warning: " + warning, 0);
  }
  return cell;
}

cv::Mat framed(const Panel& panel, const Layout& layout) {
  cv::Mat cell(layout.cell_px(), CV_8UC3, paper);
  write(cell, panel.caption, {0, cvRound(1.6 * layout.text_px)}, layout);
  panel.picture.copyTo(
      cell(cv::Rect({(cell.cols - panel.picture.cols) / 2, layout.caption_px}, panel.picture.size())));
  cv::Mat footer = cell(cv::Rect(0, cell.rows - layout.footer_px, cell.cols, layout.footer_px));
  if (panel.scale) {
    draw_scale(footer, *panel.scale, panel.ticks, layout);
  } else {
    int baseline = cvRound(1.5 * layout.text_px);
    for (const std::string& line : wrapped(panel.remark, footer.cols, layout)) {
      write(footer, line, {0, baseline}, layout);
      baseline += layout.line_px();
    }
  }
  return cell;
}

}  // namespace

cv::Mat draw_segmentation(const cv::Mat& left, const Disparity& disparity, const StereoCamera& camera,
                          const std::map<CueLevel, Segmentation>& levels, const SegmentationOptions& options,
                          int panel_px) {
  options.check();
  camera.check();
  require_option(panel_px >= 160 && panel_px <= 4096, "panel_px must be 160 to 4096");
  require_image(left, "left image");
  for (const cv::Mat* map : {&disparity.dense, &disparity.reliable}) {
    if (map->type() != CV_32FC1 || map->size() != left.size()) {
      throw InvalidInput("disparity: expected a CV_32FC1 map of the image's size, got " + describe(*map));
    }
  }
  for (const auto& [level, segmentation] : levels) {
    require_mask(segmentation.instance_ids, left.size(), "instance ids");
    if (!segmentation.heights_m.empty() &&
        (segmentation.heights_m.type() != CV_32FC1 || segmentation.heights_m.size() != left.size())) {
      throw InvalidInput("heights: expected a CV_32FC1 map of the image's size, got " +
                         describe(segmentation.heights_m));
    }
  }
  const auto shown = levels.find(options.cues);
  if (shown == levels.end()) {
    throw InvalidInput(std::string("levels: expected one for the cues ") + name_of(options.cues));
  }
  const Segmentation* with_table = nullptr;
  for (const auto& [level, segmentation] : levels) {
    const bool has = segmentation.table && !segmentation.heights_m.empty();
    if (has && (!with_table || level == options.cues)) with_table = &segmentation;
  }

  const Layout layout(left.size(), panel_px);
  const Scene scene{left,
                    disparity,
                    camera,
                    options,
                    shown->second,
                    with_table ? &*with_table->table : nullptr,
                    with_table ? with_table->heights_m : shown->second.heights_m,
                    layout};
  const auto level_cell = [&](CueLevel level) {
    const auto found = levels.find(level);
    return framed(level_panel(scene, level, found == levels.end() ? nullptr : &found->second), layout);
  };
  const std::array<cv::Mat, 8> cells{framed(hypotheses_panel(scene), layout),
                                     framed(disparity_panel(scene), layout),
                                     framed(table_panel(scene), layout),
                                     framed(heights_panel(scene), layout),
                                     level_cell(CueLevel::disparity),
                                     level_cell(CueLevel::plane),
                                     level_cell(CueLevel::colour),
                                     numbers(scene)};
  constexpr int columns = 4, rows = 2;
  const cv::Size cell = layout.cell_px();
  const int gap = layout.gap_px;
  cv::Mat sheet(rows * (cell.height + gap) + gap, columns * (cell.width + gap) + gap, CV_8UC3, paper);
  for (int i = 0; i < rows * columns; ++i) {
    const cv::Point at(gap + i % columns * (cell.width + gap), gap + i / columns * (cell.height + gap));
    cells[static_cast<std::size_t>(i)].copyTo(sheet(cv::Rect(at, cell)));
  }
  return sheet;
}

}  // namespace graspctx
