#include "graspctx/io/picture.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "detail/canvas.hpp"
#include "detail/check.hpp"
#include "detail/number_text.hpp"

namespace graspctx {

namespace {

using namespace detail;

const cv::Scalar steel(225, 215, 205);  // BGR
constexpr double axis_length_m = 0.05;
constexpr double distal_share = 0.44;  // of a finger: the outer link of a Barrett finger, 56 of 126 mm
constexpr double palm_thickness_m = 0.02;
constexpr double segment_opacity = 0.25, best_hand_opacity = 0.72, least_hand_opacity = 0.12;

// ---- The hand ---------------------------------------------------------------------------------------------

/// The convex solid between two polygons with as many corners; its faces.
std::vector<Polygon> prism(const Polygon& lower, const Polygon& upper) {
  std::vector<Polygon> faces{lower, upper};
  for (std::size_t i = 0; i < lower.size(); ++i) {
    const std::size_t next = (i + 1) % lower.size();
    faces.push_back({lower[i], lower[next], upper[next], upper[i]});
  }
  return faces;
}

/// A link of a finger from `base` to `tip` in the hand's x–z plane.
std::vector<Polygon> finger_link(const Eigen::Vector3d& base, const Eigen::Vector3d& tip,
                                 const HandOptions& hand) {
  const Eigen::Vector3d half_width = 0.5 * hand.finger_width_m * Eigen::Vector3d::UnitY();
  const Eigen::Vector3d half_thickness =
      0.5 * hand.finger_thickness_m * (tip - base).normalized().cross(Eigen::Vector3d::UnitY());
  const auto section = [&](const Eigen::Vector3d& centre) -> Polygon {
    return {centre - half_width - half_thickness, centre + half_width - half_thickness,
            centre + half_width + half_thickness, centre - half_width + half_thickness};
  };
  return prism(section(base), section(tip));
}

/// A schematic three-fingered hand in the hand frame, as convex solids: the palm, the thumb and two parallel
/// fingers, open.
std::vector<std::vector<Polygon>> hand_solids(double opening_m, const HandOptions& hand) {
  const double tip_z = hand.tip_beyond_m, palm_z = hand.tip_beyond_m - hand.finger_length_m;
  const double distal_z = tip_z - distal_share * hand.finger_length_m;
  std::vector<std::vector<Polygon>> solids;

  constexpr int palm_corners = 20;
  Polygon front, back;
  for (int i = 0; i < palm_corners; ++i) {
    const double angle = 2 * CV_PI * i / palm_corners;
    const Eigen::Vector3d rim(hand.palm_radius_m * std::cos(angle), hand.palm_radius_m * std::sin(angle), 0);
    front.push_back(rim + palm_z * Eigen::Vector3d::UnitZ());
    back.push_back(rim + (palm_z - palm_thickness_m) * Eigen::Vector3d::UnitZ());
  }
  solids.push_back(prism(front, back));

  const double pad_x = 0.5 * (opening_m + hand.finger_thickness_m);
  const double spread_y = 0.5 * hand.finger_spread_m;
  for (const auto& [side, y] : {std::pair(-1.0, 0.0), std::pair(1.0, -spread_y), std::pair(1.0, spread_y)}) {
    const Eigen::Vector3d hinge(side * hand.palm_radius_m, y, palm_z), knuckle(side * pad_x, y, distal_z),
        tip(side * pad_x, y, tip_z);
    solids.push_back(finger_link(hinge, knuckle, hand));
    solids.push_back(finger_link(knuckle, tip, hand));
  }
  return solids;
}

/// The visible faces of the hand, shaded, the farthest first.
void draw_hand(Canvas& canvas, const GraspConfiguration& grasp, const StereoCamera& camera,
               const HandOptions& hand, double opacity) {
  const Eigen::Affine3d cam_from_hand(grasp.cam_from_hand);
  if (!grasp.cam_from_hand.allFinite() || !std::isfinite(grasp.opening_m)) return;

  struct Face {
    std::vector<cv::Point> corners;
    double distance_m, shade;
  };
  std::vector<Face> faces;
  for (const std::vector<Polygon>& solid : hand_solids(grasp.opening_m, hand)) {
    std::vector<Polygon> solid_faces = solid;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (Polygon& face : solid_faces) {
      for (Eigen::Vector3d& corner : face) corner = cam_from_hand * corner;
    }
    for (int end : {0, 1}) {
      const Polygon& cap = solid_faces[static_cast<std::size_t>(end)];
      for (const Eigen::Vector3d& corner : cap) centre += corner / (2.0 * static_cast<double>(cap.size()));
    }
    for (const Polygon& face : solid_faces) {
      Eigen::Vector3d face_centre = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& corner : face) face_centre += corner / static_cast<double>(face.size());
      Eigen::Vector3d outward = (face[1] - face[0]).cross(face[2] - face[0]).normalized();
      if (outward.dot(face_centre - centre) < 0) outward = -outward;
      const double towards_camera = -outward.dot(face_centre.normalized());
      if (towards_camera <= 0) continue;
      std::vector<cv::Point> corners = project_polygon(face, camera, canvas);
      if (corners.size() < 3) continue;
      faces.push_back({std::move(corners), face_centre.norm(), 0.45 + 0.55 * towards_camera});
    }
  }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Face& a, const Face& b) { return a.distance_m > b.distance_m; });

  cv::Mat layer = canvas.picture.clone();
  for (const Face& face : faces) {
    const cv::Scalar colour = (grasp.feasible ? steel : dark_grey) * face.shade;
    cv::fillConvexPoly(layer, face.corners, colour, cv::LINE_AA, sub_pixel_bits);
    cv::fillConvexPoly(canvas.occupied, face.corners, hides_hand, cv::LINE_8, sub_pixel_bits);
    cv::polylines(layer, face.corners, true, colour * 0.55, 1, cv::LINE_AA, sub_pixel_bits);
  }
  cv::addWeighted(layer, opacity, canvas.picture, 1 - opacity, 0, canvas.picture);
}

void draw_axes(Canvas& canvas, const GraspConfiguration& grasp, const StereoCamera& camera, bool best) {
  const Eigen::Vector3d origin = grasp.cam_from_hand.block<3, 1>(0, 3);
  const std::vector<cv::Scalar> colours =
      grasp.feasible ? std::vector{red, green, blue} : std::vector{grey, grey, grey};
  const double length_m = best ? axis_length_m : 0.5 * axis_length_m;
  for (const auto& [halo, width_px] : {std::pair(true, 2), std::pair(false, 0)}) {
    for (int axis : {0, 1, 2}) {
      const Eigen::Vector3d end = origin + length_m * grasp.cam_from_hand.block<3, 1>(0, axis);
      const int extra_px = width_px * canvas.stroke_px;
      draw_line_3d(canvas, origin, end, camera, halo ? black : colours[static_cast<std::size_t>(axis)],
                   (best ? 2 : 1) * canvas.stroke_px + extra_px);
    }
  }
}

// ---- What was seen ----------------------------------------------------------------------------------------

void draw_segments_of(Canvas& canvas, const Detection& detection) {
  const cv::Mat& ids = detection.segmentation.instance_ids;
  if (ids.empty()) return;
  std::vector<Tint> segments;
  for (const DetectedObject& object : detection.objects) {
    segments.push_back(
        {scaled_mask(ids == object.id, canvas.picture.size()), segment_colour(segments.size())});
  }
  draw_segments(canvas, segments, segment_opacity, canvas.stroke_px);
}

/// Width (px) of the patches of a grid: column c's centre lies at (c + ½)·width − ½.
double patch_width_px(const PatchDescriptors& patches) {
  return (patches.centres_px.front().x + 0.5) / (patches.cells.front().x + 0.5);
}

cv::Scalar probability_colour(double probability) {
  cv::Mat colour(1, 1, CV_8UC1, cv::Scalar(255 * std::clamp(probability, 0.0, 1.0)));
  cv::applyColorMap(colour, colour, cv::COLORMAP_PLASMA);
  const auto bgr = colour.at<cv::Vec3b>(0, 0);
  return {static_cast<double>(bgr[0]), static_cast<double>(bgr[1]), static_cast<double>(bgr[2])};
}

/// The patches' probabilities: the more probable, the more opaque.
void draw_probabilities(Canvas& canvas, const ObjectIntermediates& seen) {
  const PatchDescriptors& patches = seen.patches;
  const auto count = std::min(
      {patches.centres_px.size(), patches.cells.size(), static_cast<std::size_t>(seen.probabilities.size())});
  if (count == 0) return;
  const Eigen::Vector2d half_px = Eigen::Vector2d::Constant(0.5 * patch_width_px(patches));
  for (std::size_t m = 0; m < count; ++m) {
    const double probability = seen.probabilities[static_cast<Eigen::Index>(m)];
    if (!std::isfinite(probability)) continue;
    const Eigen::Vector2d centre(patches.centres_px[m].x, patches.centres_px[m].y);
    const Eigen::Vector2d from = canvas.from_image(seen.fovea.left.image_from_view(centre - half_px));
    const Eigen::Vector2d to = canvas.from_image(seen.fovea.left.image_from_view(centre + half_px));
    if (!drawable(from) || !drawable(to)) continue;
    // Pixel p covers [p − ½, p + ½).
    const cv::Point corner(cvRound(from.x() + 0.5), cvRound(from.y() + 0.5)),
        opposite(cvRound(to.x() + 0.5), cvRound(to.y() + 0.5));
    const cv::Rect patch = cv::Rect(corner, opposite) & cv::Rect({0, 0}, canvas.picture.size());
    if (patch.empty()) continue;
    cv::Mat pixels = canvas.picture(patch);
    const double opacity = 0.2 + 0.55 * std::clamp(probability, 0.0, 1.0);
    cv::addWeighted(pixels, 1 - opacity,
                    cv::Mat(patch.size(), pixels.type(), probability_colour(probability)), opacity, 0,
                    pixels);
  }
}

void draw_contour(Canvas& canvas, const ObjectIntermediates& seen) {
  // Small objects get small dots: 300 samples of a mug far away would hide it.
  const double radius_px =
      std::clamp(1.2 * canvas.scale / seen.fovea.left.scale, 0.5, 0.9 * canvas.stroke_px);
  for (const cv::Point2f& point : seen.contour.points) {
    const Eigen::Vector2d px =
        canvas.from_image(seen.fovea.left.image_from_view(Eigen::Vector2d(point.x, point.y)));
    draw_disc(canvas.picture, px, radius_px, white);
  }
}

/// The plane of the pose as the parallelogram of its axes, and the two axes (Fig. 4).
void draw_pose(Canvas& canvas, const ObjectPose& pose, const StereoCamera& camera) {
  const Eigen::Vector3d &c = pose.centroid_m, &a = pose.major_axis_m, &b = pose.minor_axis_m;
  const Polygon plane{c + a + b, c + a - b, c - a - b, c - a + b};
  for (std::size_t i = 0; i < plane.size(); ++i) {
    draw_line_3d(canvas, plane[i], plane[(i + 1) % plane.size()], camera, white, canvas.stroke_px);
  }
  draw_line_3d(canvas, c, c + a, camera, white, canvas.stroke_px);
  draw_line_3d(canvas, c, c + b, camera, white, canvas.stroke_px);
}

/// What the patches' colours mean.
void draw_probability_scale(Canvas& canvas) {
  const int stroke = canvas.stroke_px, width = 12 * stroke, height = 110 * stroke, margin = 10 * stroke;
  const double text_px = 11 * stroke;
  const cv::Rect bar(canvas.picture.cols - margin - width, canvas.picture.rows - margin - height, width,
                     height);
  const cv::Rect whole({0, 0}, canvas.picture.size());
  if ((bar & whole) != bar) return;
  for (int row = 0; row < height; ++row) {
    canvas.picture(cv::Rect(bar.x, bar.y + row, width, 1))
        .setTo(probability_colour(1 - static_cast<double>(row) / (height - 1)));
  }
  cv::rectangle(canvas.picture, bar, black, stroke);
  const auto label = [&](const std::string& text, int baseline) {
    const cv::Point at(bar.x - text_size(text, text_px, stroke).width - 4 * stroke, baseline);
    draw_text(canvas.picture, text, at, text_px, black, 3 * stroke);
    draw_text(canvas.picture, text, at, text_px, white, stroke);
  };
  label("P = 1", bar.y + static_cast<int>(text_px));
  label("0", bar.y + height);
}

// ---- Labels -----------------------------------------------------------------------------------------------

/// Rank and probability beside the grasp point.
void draw_rank(Canvas& canvas, const GraspConfiguration& grasp, const cv::Scalar& colour, bool best,
               std::vector<cv::Rect>& placed) {
  const std::string text =
      std::to_string(grasp.rank) + ": " +
      (std::isfinite(grasp.probability) ? decimal_text(std::clamp(grasp.probability, 0.0, 1.0), 2) : "?");
  draw_label(canvas, canvas.from_image(grasp.left_px),
             {{text}, (best ? 15.0 : 11.0) * canvas.stroke_px, colour, grasp.feasible ? white : grey},
             placed);
}

/// Which model answers for an object, over its box; nothing where the models cannot tell.
void draw_answer(Canvas& canvas, const DetectedObject& object, const cv::Scalar& colour,
                 std::vector<cv::Rect>& placed) {
  if (!object.familiarity) return;
  const std::string answer = object.unfamiliar ? "unfamiliar" : object.model_name;
  const cv::Rect& box = object.bounding_box_px;
  draw_label(canvas, canvas.from_image({box.x + 0.5 * box.width, static_cast<double>(box.y)}),
             {{answer + ", familiarity " + decimal_text(std::clamp(*object.familiarity, 0.0, 1.0), 2)},
              11.0 * canvas.stroke_px,
              colour,
              object.unfamiliar ? grey : white},
             placed);
}

/// The grasps of one object, the best last and so on top.
void draw_grasps(Canvas& canvas, const DetectedObject& object, const cv::Scalar& colour,
                 const StereoCamera& camera, const PictureOptions& options, double hand_opacity) {
  const auto count = std::min(object.grasps.size(), static_cast<std::size_t>(options.max_grasps));
  for (std::size_t i = count; i-- > 0;) {
    const bool best = i == 0;
    if (best) draw_hand(canvas, object.grasps[i], camera, options.hand, hand_opacity);
    draw_axes(canvas, object.grasps[i], camera, best);
    const Eigen::Vector2d point = canvas.from_image(object.grasps[i].left_px);
    draw_disc(canvas.occupied, point, (best ? 30 : 15) * canvas.stroke_px, hides_hand);  // point and axes
    draw_disc(canvas.picture, point, (best ? 4.5 : 3) * canvas.stroke_px, black);
    draw_disc(canvas.picture, point, (best ? 3.5 : 2) * canvas.stroke_px,
              object.grasps[i].feasible ? colour : grey);
  }
}

}  // namespace

void PictureOptions::check() const {
  require_option(max_grasps >= 0, "picture max_grasps must not be negative");
  require_option(min_width_px >= 1 && min_width_px <= 16384, "picture min_width_px must be 1 to 16384");
  hand.check();
}

cv::Mat draw_detection(const Detection& detection, const StereoCamera& camera,
                       const PictureOptions& options) {
  options.check();
  camera.check();
  const cv::Mat& left = detection.pair.left;
  require_image(left, "the detection's left image");
  if (!detection.segmentation.instance_ids.empty()) {
    require_mask(detection.segmentation.instance_ids, left.size(), "the detection's instance ids");
  }

  constexpr double largest_side_px = 16384;  // a narrow, tall image is not enlarged beyond
  Canvas canvas =
      canvas_of(left, std::max(1.0, std::min(static_cast<double>(options.min_width_px) / left.cols,
                                             largest_side_px / std::max(left.cols, left.rows))));

  draw_segments_of(canvas, detection);
  bool any_probability = false;
  for (const DetectedObject& object : detection.objects) {
    if (options.probabilities) draw_probabilities(canvas, object.intermediates);
    if (options.contour) draw_contour(canvas, object.intermediates);
    if (options.pose && object.pose) draw_pose(canvas, *object.pose, camera);
    any_probability = any_probability || object.intermediates.probabilities.size() > 0;
  }
  if (options.probabilities && any_probability) draw_probability_scale(canvas);

  // Objects in reverse, so that the best grasp of all lies on top; then all labels, so that none is covered.
  // The hands of much less probable objects are faint: clutter would hide under them.
  const auto best_probability = [](const DetectedObject& object) {
    const double probability = object.grasps.empty() ? 0 : object.grasps.front().probability;
    return std::isfinite(probability) ? probability : 0.0;
  };
  double highest = 0;
  for (const DetectedObject& object : detection.objects)
    highest = std::max(highest, best_probability(object));
  for (std::size_t i = detection.objects.size(); i-- > 0;) {
    const double share = highest > 0 ? best_probability(detection.objects[i]) / highest : 1;
    const double opacity = std::max(least_hand_opacity, share * share * best_hand_opacity);
    draw_grasps(canvas, detection.objects[i], segment_colour(i), camera, options, opacity);
  }
  std::vector<cv::Rect> placed;
  for (std::size_t i = 0; i < detection.objects.size(); ++i) {
    const std::vector<GraspConfiguration>& grasps = detection.objects[i].grasps;
    for (std::size_t k = 0; k < std::min(grasps.size(), static_cast<std::size_t>(options.max_grasps)); ++k) {
      draw_rank(canvas, grasps[k], segment_colour(i), k == 0, placed);
    }
    draw_answer(canvas, detection.objects[i], segment_colour(i), placed);
  }
  return canvas.picture;
}

}  // namespace graspctx
