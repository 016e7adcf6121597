#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "graspctx/camera.hpp"

namespace graspctx::detail {

// Colours are BGR.
inline const cv::Scalar red(40, 40, 235), green(60, 200, 60), blue(255, 110, 30), grey(150, 150, 150),
    dark_grey(110, 110, 110), white(255, 255, 255), black(0, 0, 0);
/// One for each object, in turn.
const cv::Scalar& segment_colour(std::size_t index);

constexpr int sub_pixel_bits = 4;  // of the fixed-point coordinates that OpenCV draws with

/// How much a label would hide: values of Canvas::occupied.
constexpr int hides_segment = 40, hides_hand = 200;

/// A picture, and how pixels of the camera's image map to it. Pixel centres are at integers in both.
struct Canvas {
  cv::Mat picture;   // CV_8UC3 BGR
  cv::Mat occupied;  // CV_8UC1: how much a label would hide at each pixel
  double scale = 1;
  int stroke_px = 1;

  Eigen::Vector2d from_image(const Eigen::Vector2d& image_px) const {
    return (scale * (image_px.array() + 0.5) - 0.5).matrix();
  }
};

/// An image (CV_8UC3 BGR or CV_8UC1), enlarged or made smaller, to draw on.
Canvas canvas_of(const cv::Mat& image, double scale);

/// A mask (CV_8UC1, > 0) as large as the canvas, 255 = inside.
cv::Mat scaled_mask(const cv::Mat& mask, const cv::Size& size);

/// False for what OpenCV's fixed-point coordinates could not hold.
bool drawable(const Eigen::Vector2d& px);
int fixed_point(double px);
cv::Point fixed_point(const Eigen::Vector2d& px);

void draw_line(cv::Mat& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
               const cv::Scalar& colour, int width_px);
void draw_disc(cv::Mat& picture, const Eigen::Vector2d& centre, double radius_px, const cv::Scalar& colour);
/// text_px: the height of a capital letter.
void draw_text(cv::Mat& picture, const std::string& text, const cv::Point& baseline_left, double text_px,
               const cv::Scalar& colour, int width_px);
cv::Size text_size(const std::string& text, double text_px, int width_px);

/// Tints masks of the canvas's size and draws their outlines.
struct Tint {
  cv::Mat mask;  // CV_8UC1
  cv::Scalar colour;
};
void draw_segments(Canvas& canvas, const std::vector<Tint>& segments, double opacity, int outline_px);

/// Lines of text in a frame near a point, where it hides least and no other label stands, with a line to the
/// point. Left out where there is no room.
struct Label {
  std::vector<std::string> lines;
  double text_px = 0;
  cv::Scalar frame, ink;
};
void draw_label(Canvas& canvas, const Eigen::Vector2d& point_px, const Label& label,
                std::vector<cv::Rect>& placed);

// ---- In perspective: points in metres, in the camera frame ------------------------------------------------

using Polygon = std::vector<Eigen::Vector3d>;

/// A polygon in the picture, cut off where it comes too near to the camera; empty if nothing is left.
std::vector<cv::Point> project_polygon(const Polygon& polygon_m, const StereoCamera& camera,
                                       const Canvas& canvas);
/// A line, cut off where it comes too near to the camera.
void draw_line_3d(Canvas& canvas, Eigen::Vector3d from_m, Eigen::Vector3d to_m, const StereoCamera& camera,
                  const cv::Scalar& colour, int width_px);

}  // namespace graspctx::detail
