#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "detail/bin_effects.hpp"
#include "detail/canvas.hpp"
#include "detail/check.hpp"
#include "detail/number_text.hpp"
#include "graspctx/io/picture.hpp"

namespace graspctx {

namespace {

using namespace detail;

const cv::Scalar paper(255, 255, 255), ink(40, 40, 40), rule(200, 200, 200), neutral(232, 232, 232),
    speaks_for(178, 114, 0), speaks_against(0, 94, 213);  // BGR; blue and vermilion of Okabe and Ito
constexpr int margin_px = 24, view_px = 720, dial_px = 206, thumbnail_px = 176, stroke_px = 1;
constexpr double text_px = 14, title_px = 18;
constexpr int line_px = 26;
constexpr std::size_t thumbnails = 5;  // of each label

void write(cv::Mat& picture, const std::string& text, const cv::Point& baseline_left,
           double height_px = text_px, int width_px = stroke_px) {
  draw_text(picture, text, baseline_left, height_px, ink, width_px);
}

std::string signed_text(double value, int decimals = 2) {
  return (value >= 0 ? "+" : "") + decimal_text(value, decimals);
}

/// An effect as a colour: `share` of the largest, -1 to 1. The root keeps small ones visible.
cv::Scalar effect_colour(double share) {
  const double strength = std::sqrt(std::min(1.0, std::abs(share)));
  return neutral * (1 - strength) + (share >= 0 ? speaks_for : speaks_against) * strength;
}

double share_of(double effect, double largest) {
  return largest > 0 ? effect / largest : 0;
}

/// From pixels of a view to those of the picture.
struct Placement {
  cv::Point corner_px;
  double scale = 1;
  Eigen::Vector2d at(double u, double v) const {
    return {corner_px.x + scale * (u + 0.5) - 0.5, corner_px.y + scale * (v + 0.5) - 0.5};
  }
};

/// A view in the middle of a square cell.
Placement place_view(cv::Mat& picture, const cv::Mat& view, const cv::Point& cell_px, int side_px) {
  Placement placement;
  placement.scale = static_cast<double>(side_px) / std::max(view.cols, view.rows);
  const Canvas canvas = canvas_of(view, placement.scale);
  placement.corner_px =
      cell_px + cv::Point((side_px - canvas.picture.cols) / 2, (side_px - canvas.picture.rows) / 2);
  canvas.picture.copyTo(picture(cv::Rect(placement.corner_px, canvas.picture.size())));
  return placement;
}

void draw_square(cv::Mat& picture, const Placement& placement, const cv::Point2f& centre_px, double side_px,
                 int width_px) {
  const double half = 0.5 * side_px;
  const cv::Point2f& c = centre_px;
  const std::vector<cv::Point> corners{
      fixed_point(placement.at(c.x - half, c.y - half)), fixed_point(placement.at(c.x + half, c.y - half)),
      fixed_point(placement.at(c.x + half, c.y + half)), fixed_point(placement.at(c.x - half, c.y + half))};
  cv::polylines(picture, corners, true, paper, width_px + 2, cv::LINE_AA, sub_pixel_bits);
  cv::polylines(picture, corners, true, ink, width_px, cv::LINE_AA, sub_pixel_bits);
}

// ---- The view ---------------------------------------------------------------------------------------------

/// Grey and faint, so that the colours of the points stand out.
cv::Mat faint(const cv::Mat& image) {
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(grey, CV_8U, 0.5, 120);
  return grey;
}

void draw_view(cv::Mat& picture, const GraspExplanation& explanation, const cv::Point& cell_px) {
  cv::Mat cell = picture(cv::Rect(cell_px, cv::Size(view_px, view_px)));  // windows may reach out of the view
  const Placement placement = place_view(cell, faint(explanation.view.image), {0, 0}, view_px);
  const PatchExplanation& patch = explanation.patch;
  double largest = 0;
  for (const double effect : patch.point_effects) largest = std::max(largest, std::abs(effect));

  // The strongest last and so on top.
  std::vector<std::size_t> order(patch.point_effects.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(patch.point_effects[a]) < std::abs(patch.point_effects[b]);
  });
  for (const std::size_t i : order) {
    const cv::Point2f& point = explanation.contour.points[i];
    const double share = share_of(patch.point_effects[i], largest);
    const double radius_px = 3.5 + 3.5 * std::sqrt(std::abs(share));
    draw_disc(cell, placement.at(point.x, point.y), radius_px + 1, ink);
    draw_disc(cell, placement.at(point.x, point.y), radius_px, effect_colour(share));
  }
  for (const int window : {2, 1, 0}) {
    draw_square(cell, placement, patch.centre_px, window_px(explanation, window), stroke_px);
  }
  draw_square(cell, placement, patch.centre_px, explanation.descriptor.patch.patch_px, 2 * stroke_px);
}

/// What the colours mean, for points and for bins.
void draw_legend(cv::Mat& picture, const GraspExplanation& explanation, const cv::Point& corner_px) {
  double point = 0;
  for (const double effect : explanation.patch.point_effects) point = std::max(point, std::abs(effect));
  const double bin = explanation.patch.bin_effects.cwiseAbs().maxCoeff();
  const std::string against = "against", in_favour = "for a grasping point";
  const int bar_px = 200, left_px = corner_px.x + text_size(against, text_px, stroke_px).width + 10;
  write(picture, against, corner_px + cv::Point(0, 16));
  for (int x = 0; x < bar_px; ++x) {
    picture(cv::Rect(left_px + x, corner_px.y, 1, 18)).setTo(effect_colour(2.0 * x / (bar_px - 1) - 1));
  }
  write(picture, in_favour, {left_px + bar_px + 10, corner_px.y + 16});
  write(picture,
        "the ends: " + decimal_text(point, 3) + " of f for a point left out, " + decimal_text(bin, 3) +
            " for a bin at its mean",
        corner_px + cv::Point(0, 16 + line_px));
}

// ---- The bins ---------------------------------------------------------------------------------------------

/// The log-polar bins of one histogram, as they lie around a sample in the image.
void draw_dial(cv::Mat& picture, const BinGrid& effects, double largest, const cv::Point& centre_px) {
  const double ring_px = 0.5 * dial_px / static_cast<double>(effects.cols());
  const double sector = 2 * CV_PI / static_cast<double>(effects.rows());
  const auto on_circle = [&](double radius_px, double angle) {
    return fixed_point(Eigen::Vector2d(centre_px.x + radius_px * std::cos(angle),
                                       centre_px.y + radius_px * std::sin(angle)));
  };
  for (Eigen::Index angle = 0; angle < effects.rows(); ++angle) {
    for (Eigen::Index ring = 0; ring < effects.cols(); ++ring) {
      constexpr int steps = 12;  // of an arc
      std::vector<cv::Point> corners;
      for (int step = 0; step <= steps; ++step) {
        const double at = (static_cast<double>(angle) + static_cast<double>(step) / steps) * sector;
        corners.push_back(on_circle(static_cast<double>(ring + 1) * ring_px, at));
      }
      for (int step = steps; step >= 0; --step) {
        const double at = (static_cast<double>(angle) + static_cast<double>(step) / steps) * sector;
        corners.push_back(on_circle(static_cast<double>(ring) * ring_px, at));
      }
      cv::fillPoly(picture, std::vector<std::vector<cv::Point>>{corners},
                   effect_colour(share_of(effects(angle, ring), largest)), cv::LINE_AA, sub_pixel_bits);
      cv::polylines(picture, corners, true, rule, stroke_px, cv::LINE_AA, sub_pixel_bits);
    }
  }
}

void draw_dials(cv::Mat& picture, const GraspExplanation& explanation, const cv::Point& corner_px) {
  const double largest = explanation.patch.bin_effects.cwiseAbs().maxCoeff();
  const int parts = has_outline(explanation) ? 2 : 1;
  for (int window = 0; window < 3; ++window) {
    const int top_px = corner_px.y + window * view_px / 3;
    write(picture,
          "bins, " + std::to_string(window_px(explanation, window)) +
              " px window: " + signed_text(window_effect(explanation, window)),
          {corner_px.x, top_px + 14});
    for (int part = 0; part < parts; ++part) {
      const cv::Point centre(corner_px.x + dial_px / 2 + part * (dial_px + margin_px),
                             top_px + 22 + dial_px / 2);
      draw_dial(picture, bin_grid(explanation, window, part == 1), largest, centre);
    }
  }
  int below_px = corner_px.y + view_px + 16;
  if (parts == 2) {
    write(picture, "left: all points, right: outline", {corner_px.x, below_px});
    below_px += line_px;
  }
  std::string radii = "rings to";
  for (const double radius_px : explanation.patch.ring_radii_px) radii += " " + decimal_text(radius_px, 0);
  write(picture, radii + " px", {corner_px.x, below_px});
  if (explanation.descriptor.shape_context.relative_to_gradient) {
    write(picture, "angles from each sample's gradient", {corner_px.x, below_px + line_px});
  }
}

// ---- The training images ----------------------------------------------------------------------------------

bool are_drawn(const std::vector<NearImage>& images) {
  return !images.empty() && images.front().patch.has_value();
}

int images_height_px(const std::vector<NearImage>& images) {
  return line_px + (are_drawn(images) ? thumbnail_px + line_px + 10 : line_px);
}

/// Cut with dots where it is wider than that.
std::string fitted(const std::string& text, int width_px) {
  if (text_size(text, text_px, stroke_px).width <= width_px) return text;
  std::string shorter = text;
  while (!shorter.empty() && text_size(shorter + "...", text_px, stroke_px).width > width_px)
    shorter.pop_back();
  return shorter + "...";
}

void draw_images(cv::Mat& picture, const std::vector<NearImage>& images, int patch_px,
                 const std::string& heading, const cv::Point& corner_px) {
  write(picture, heading, corner_px + cv::Point(0, 16));
  const int cell_px = (picture.cols - 2 * margin_px) / static_cast<int>(thumbnails);
  for (std::size_t i = 0; i < std::min(images.size(), thumbnails); ++i) {
    const NearImage& image = images[i];
    const int left_px = corner_px.x + static_cast<int>(i) * cell_px;
    int baseline_px = corner_px.y + line_px + 16;
    if (image.patch) {
      const Placement placement =
          place_view(picture, image.patch->view.image, {left_px, corner_px.y + line_px}, thumbnail_px);
      draw_square(picture, placement, image.patch->centre_px, patch_px, 2 * stroke_px);
      baseline_px += thumbnail_px;
    }
    write(picture, fitted(decimal_text(image.similarity, 2) + " " + image.name, cell_px - 10),
          {left_px, baseline_px});
  }
}

}  // namespace

cv::Mat draw_explanation(const GraspExplanation& explanation) {
  require_image(explanation.view.image, "the explanation's view");
  const PatchExplanation& patch = explanation.patch;
  if (patch.point_effects.size() != explanation.contour.points.size() ||
      patch.bin_effects.size() != 3 * explanation.descriptor.shape_context.bins()) {
    throw InvalidInput("explanation: expected an effect for each contour sample and each bin");
  }
  const int parts = has_outline(explanation) ? 2 : 1;
  const int dials_px = std::max(parts * (dial_px + margin_px), 330);
  const bool knows_images = !patch.graspable.empty() || !patch.not_graspable.empty();
  const int title_height_px = 2 * line_px + 14, main_height_px = view_px + 2 * line_px + margin_px;
  const int below_px =
      knows_images ? images_height_px(patch.graspable) + images_height_px(patch.not_graspable) : line_px;
  cv::Mat picture(margin_px + title_height_px + main_height_px + below_px + margin_px,
                  3 * margin_px + view_px + dials_px, CV_8UC3, paper);

  const GraspConfiguration& grasp = explanation.grasp;
  write(picture,
        "object " + std::to_string(explanation.object_id) + ", grasp " + std::to_string(grasp.rank) +
            ": P = " + decimal_text(grasp.probability, 2) + " = left " +
            decimal_text(grasp.probability_left, 2) + " x right " + decimal_text(grasp.probability_right, 2),
        {margin_px, margin_px + 20}, title_px, 2 * stroke_px);
  write(picture,
        "what the left view's f = " + signed_text(patch.decision_value) + " rests on" +
            (patch.other_effect ? ", beside appearance: " + signed_text(*patch.other_effect) : ""),
        {margin_px, margin_px + 20 + line_px});

  const int top_px = margin_px + title_height_px;
  draw_view(picture, explanation, {margin_px, top_px});
  draw_dials(picture, explanation, {2 * margin_px + view_px, top_px});
  draw_legend(picture, explanation, {margin_px, top_px + view_px + 8});
  cv::Point corner_px(margin_px, top_px + main_height_px);
  if (!knows_images) {
    write(picture, "The model does not say which images it was trained on.", corner_px + cv::Point(0, 16));
    return picture;
  }
  const int patch_px = explanation.descriptor.patch.patch_px;
  draw_images(picture, patch.graspable, patch_px, "nearest training images, graspable there:", corner_px);
  corner_px.y += images_height_px(patch.graspable);
  draw_images(picture, patch.not_graspable, patch_px,
              "nearest training images, not graspable there:", corner_px);
  return picture;
}

}  // namespace graspctx
