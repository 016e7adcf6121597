#include "canvas.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace graspctx::detail {

namespace {

constexpr double near_m = 0.02;      // nothing nearer to the camera is drawn
constexpr double drawable_px = 1e5;  // beyond this the fixed-point coordinates could overflow

/// The point of the line a–b at the nearest depth that is drawn.
Eigen::Vector3d at_near_plane(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return a + (near_m - a.z()) / (b.z() - a.z()) * (b - a);
}

}  // namespace

const cv::Scalar& segment_colour(std::size_t index) {
  static const std::vector<cv::Scalar> colours{{0, 190, 255},   {230, 160, 40}, {90, 200, 90},
                                               {200, 110, 220}, {80, 110, 255}, {220, 220, 60},
                                               {60, 230, 230},  {180, 140, 255}};
  return colours[index % colours.size()];
}

Canvas canvas_of(const cv::Mat& image, double scale) {
  Canvas canvas;
  canvas.scale = scale;
  const cv::Size size(std::max(1, cvRound(scale * image.cols)), std::max(1, cvRound(scale * image.rows)));
  cv::resize(image, canvas.picture, size, 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  if (canvas.picture.channels() == 1) cv::cvtColor(canvas.picture, canvas.picture, cv::COLOR_GRAY2BGR);
  canvas.occupied = cv::Mat::zeros(size, CV_8UC1);
  canvas.stroke_px = std::max(1, cvRound(size.width / 900.0));
  return canvas;
}

cv::Mat scaled_mask(const cv::Mat& mask, const cv::Size& size) {
  cv::Mat scaled;
  cv::resize(mask > 0, scaled, size, 0, 0, size.width < mask.cols ? cv::INTER_AREA : cv::INTER_LINEAR);
  return scaled > 127;
}

bool drawable(const Eigen::Vector2d& px) {
  return px.allFinite() && px.cwiseAbs().maxCoeff() < drawable_px;
}

int fixed_point(double px) {
  return static_cast<int>(std::lround(px * (1 << sub_pixel_bits)));
}
cv::Point fixed_point(const Eigen::Vector2d& px) {
  return {fixed_point(px.x()), fixed_point(px.y())};
}

void draw_line(cv::Mat& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
               const cv::Scalar& colour, int width_px) {
  if (!drawable(from) || !drawable(to)) return;
  cv::line(picture, fixed_point(from), fixed_point(to), colour, width_px, cv::LINE_AA, sub_pixel_bits);
}

void draw_disc(cv::Mat& picture, const Eigen::Vector2d& centre, double radius_px, const cv::Scalar& colour) {
  if (!drawable(centre)) return;
  cv::circle(picture, fixed_point(centre), fixed_point(radius_px), colour, cv::FILLED, cv::LINE_AA,
             sub_pixel_bits);
}

void draw_text(cv::Mat& picture, const std::string& text, const cv::Point& baseline_left, double text_px,
               const cv::Scalar& colour, int width_px) {
  cv::putText(picture, text, baseline_left, cv::FONT_HERSHEY_SIMPLEX, text_px / 22.0, colour, width_px,
              cv::LINE_AA);
}

cv::Size text_size(const std::string& text, double text_px, int width_px) {
  int below = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, text_px / 22.0, width_px, &below);
}

void draw_segments(Canvas& canvas, const std::vector<Tint>& segments, double opacity, int outline_px) {
  cv::Mat layer = canvas.picture.clone();
  for (const Tint& segment : segments) {
    layer.setTo(segment.colour, segment.mask);
    canvas.occupied.setTo(hides_segment, segment.mask);
  }
  cv::addWeighted(layer, opacity, canvas.picture, 1 - opacity, 0, canvas.picture);
  for (const Tint& segment : segments) {
    std::vector<std::vector<cv::Point>> outlines;
    cv::findContours(segment.mask, outlines, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
    cv::polylines(canvas.picture, outlines, true, segment.colour, outline_px, cv::LINE_AA);
  }
}

void draw_label(Canvas& canvas, const Eigen::Vector2d& point_px, const Label& label,
                std::vector<cv::Rect>& placed) {
  const cv::Rect whole({0, 0}, canvas.picture.size());
  if (!drawable(point_px) || !whole.contains(cv::Point(cvRound(point_px.x()), cvRound(point_px.y())))) return;

  const int stroke = canvas.stroke_px, padding = 3 * stroke;
  const int line_px = cvRound(1.5 * label.text_px);
  cv::Size size;
  for (const std::string& line : label.lines) {
    const cv::Size text = text_size(line, label.text_px, stroke);
    size = {std::max(size.width, text.width), size.height + (size.empty() ? text.height : line_px)};
  }
  size += cv::Size(2 * padding, 2 * padding);

  // Around the point in growing circles: near to it, but hiding as little as possible and no other label.
  cv::Rect box;
  double least_cost = std::numeric_limits<double>::infinity();
  for (int ring = 2; ring <= 9; ++ring) {
    for (int step = 0; step < 16; ++step) {
      const double angle = -CV_PI / 4 + step * CV_PI / 8, distance_px = 14.0 * ring * stroke;
      const cv::Rect candidate({cvRound(point_px.x() + distance_px * std::cos(angle) - 0.5 * size.width),
                                cvRound(point_px.y() + distance_px * std::sin(angle) - 0.5 * size.height)},
                               size);
      if ((candidate & whole) != candidate ||
          std::any_of(placed.begin(), placed.end(),
                      [&](const cv::Rect& other) { return !(candidate & other).empty(); })) {
        continue;
      }
      const double cost = 8 * ring + cv::mean(canvas.occupied(candidate))[0];
      if (cost < least_cost) {
        least_cost = cost;
        box = candidate;
      }
    }
  }
  if (box.empty()) return;
  placed.push_back(box);
  draw_line(canvas.picture, point_px, {box.x + 0.5 * box.width, box.y + 0.5 * box.height}, label.frame,
            stroke);
  cv::Mat background = canvas.picture(box);
  cv::addWeighted(background, 0.15, cv::Mat(size, background.type(), cv::Scalar(30, 30, 30)), 0.85, 0,
                  background);
  cv::rectangle(canvas.picture, box, label.frame, stroke, cv::LINE_AA);
  for (std::size_t i = 0; i < label.lines.size(); ++i) {
    const int lines_below = static_cast<int>(label.lines.size() - 1 - i);
    draw_text(canvas.picture, label.lines[i],
              {box.x + padding, box.y + box.height - padding - lines_below * line_px}, label.text_px,
              label.ink, stroke);
  }
}

std::vector<cv::Point> project_polygon(const Polygon& polygon_m, const StereoCamera& camera,
                                       const Canvas& canvas) {
  Polygon visible;
  for (std::size_t i = 0; i < polygon_m.size(); ++i) {
    const Eigen::Vector3d &a = polygon_m[i], &b = polygon_m[(i + 1) % polygon_m.size()];
    const bool a_visible = a.z() >= near_m, b_visible = b.z() >= near_m;
    if (a_visible) visible.push_back(a);
    if (a_visible != b_visible) visible.push_back(at_near_plane(a, b));
  }
  std::vector<cv::Point> corners;
  for (const Eigen::Vector3d& point_m : visible) {
    const Eigen::Vector2d px = canvas.from_image(camera.project(point_m));
    if (!drawable(px)) return {};
    corners.push_back(fixed_point(px));
  }
  return corners;
}

void draw_line_3d(Canvas& canvas, Eigen::Vector3d from_m, Eigen::Vector3d to_m, const StereoCamera& camera,
                  const cv::Scalar& colour, int width_px) {
  if (!from_m.allFinite() || !to_m.allFinite() || std::max(from_m.z(), to_m.z()) < near_m) return;
  if (from_m.z() < near_m) from_m = at_near_plane(from_m, to_m);
  if (to_m.z() < near_m) to_m = at_near_plane(to_m, from_m);
  draw_line(canvas.picture, canvas.from_image(camera.project(from_m)),
            canvas.from_image(camera.project(to_m)), colour, width_px);
}

}  // namespace graspctx::detail
