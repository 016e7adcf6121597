#include "detail/scene_cues.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "detail/colour_bins.hpp"
#include "detail/heights.hpp"
#include "detail/plain_table_shadow.hpp"
#include "detail/plane_geometry.hpp"
#include "detail/table_evidence.hpp"

namespace graspctx::detail {

namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

/// log of how common each pixel's colour is on the ground, against all colours alike.
cv::Mat likeness_to(const cv::Mat& ground, const cv::Mat& bgr) {
  const cv::Mat bins = colour_indices(smooth_colours(bgr));
  std::array<double, colour_bins> seen;
  seen.fill(1);  // a colour never seen is unlikely, not impossible
  double sum = colour_bins;
  for (int v = 0; v < bins.rows; ++v) {
    for (int u = 0; u < bins.cols; ++u) {
      if (!ground.at<uchar>(v, u)) continue;
      ++seen[bins.at<ushort>(v, u)];
      ++sum;
    }
  }
  cv::Mat likeness(bgr.size(), CV_32FC1);
  for (int v = 0; v < bins.rows; ++v) {
    for (int u = 0; u < bins.cols; ++u) {
      likeness.at<float>(v, u) =
          static_cast<float>(std::log(seen[bins.at<ushort>(v, u)] * double(colour_bins) / sum));
    }
  }
  return likeness;
}

/// How far (m) inside the hull of the table the point of the plane lies that each pixel would show.
cv::Mat distance_inside(const TableFrame& frame, const TablePlane& plane, const StereoCamera& camera,
                        const cv::Size& size) {
  constexpr int step = 4;
  cv::Mat coarse((size.height + step - 1) / step, (size.width + step - 1) / step, CV_32FC1, cv::Scalar(-1));
  if (frame.hull.size() >= 3) {
    for (int v = 0; v < coarse.rows; ++v) {
      for (int u = 0; u < coarse.cols; ++u) {
        const double at_u = u * step, at_v = v * step, d = plane_disparity(plane, at_u, at_v);
        if (d + camera.doffs_px <= 0) continue;
        coarse.at<float>(v, u) = static_cast<float>(
            cv::pointPolygonTest(frame.hull, frame.of(camera.triangulate({at_u, at_v}, d)), true));
      }
    }
  }
  cv::Mat fine;
  cv::resize(coarse, fine, {coarse.cols * step, coarse.rows * step}, 0, 0, cv::INTER_NEAREST);
  return fine(cv::Rect({0, 0}, size)).clone();
}

cv::Mat over_plane(const cv::Mat& disparity_px, const TablePlane& plane) {
  cv::Mat residual(disparity_px.size(), CV_32FC1);
  for (int v = 0; v < residual.rows; ++v) {
    for (int u = 0; u < residual.cols; ++u) {
      residual.at<float>(v, u) =
          disparity_px.at<float>(v, u) - static_cast<float>(plane_disparity(plane, u, v));
    }
  }
  return residual;
}

cv::Mat points_of(const cv::Mat& disparity_px, const StereoCamera& camera) {
  constexpr float least_px = 1;  // of disparity: farther away nothing is told from anything
  cv::Mat points(disparity_px.size(), CV_32FC3, cv::Scalar::all(unknown));
  for (int v = 0; v < points.rows; ++v) {
    for (int u = 0; u < points.cols; ++u) {
      const double d = disparity_px.at<float>(v, u);
      if (!(d + camera.doffs_px > least_px)) continue;
      const Eigen::Vector3d point = camera.triangulate({double(u), double(v)}, d);
      points.at<cv::Vec3f>(v, u) = {float(point.x()), float(point.y()), float(point.z())};
    }
  }
  return points;
}

}  // namespace

SceneCues scene_cues(const RectifiedPair& pair, const Disparity& disparity, const StereoCamera& camera,
                     const TableView& view) {
  const cv::Size size = pair.left.size();
  SceneCues cues;
  cues.has_plane = view.plane.has_value();
  cues.has_plain_table = view.plain.has_value();
  cues.image = pair.left;
  if (pair.left.channels() == 1) cv::cvtColor(pair.left, cues.image, cv::COLOR_GRAY2BGR);
  cues.disparity_px = disparity.dense.clone();
  cv::Mat ground = cv::Mat::zeros(size, CV_8UC1);
  if (view.plane) {
    cues.residual_px = view.relief.residual_px;
    cues.sigma_px = view.relief.sigma_px;
    cues.dense_px = over_plane(disparity.dense, *view.plane);
    cues.height_m = heights_over_plane(cues.residual_px, *view.plane, camera);
    cues.dense_height_m = heights_over_plane(cues.dense_px, *view.plane, camera);
    cues.table_misfit = misfit_of_table(view.relief, *view.plane);
    cues.inside_table_m = distance_inside(view.frame, *view.plane, camera, size);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const float r = cues.residual_px.at<float>(v, u);
        cues.disparity_px.at<float>(v, u) = std::isnan(r)
                                                ? disparity.dense.at<float>(v, u)
                                                : r + static_cast<float>(plane_disparity(*view.plane, u, v));
        constexpr float on_table_px = 0.3F;
        if (std::abs(r) < on_table_px && cues.inside_table_m.at<float>(v, u) >= 0)
          ground.at<uchar>(v, u) = 255;
      }
    }
  } else {
    const cv::Mat nothing(size, CV_32FC1, cv::Scalar(unknown));
    cues.residual_px = cues.dense_px = cues.height_m = cues.dense_height_m = nothing;
    cues.sigma_px = cv::Mat(size, CV_32FC1, cv::Scalar(1));
    cues.table_misfit = cv::Mat(size, CV_32FC1, cv::Scalar(-1));
    cues.inside_table_m = cv::Mat(size, CV_32FC1, cv::Scalar(0));
  }
  if (view.plain) {
    const TableComparison compared = compare_with_table(cues.image, *view.plain);
    cues.plain_sigmas = compared.sigmas;
    cues.plain_light = compared.light;
    cues.plain_off_hue = compared.off_hue;
    cues.on_plain_table = view.plain->extent;
    ground |= view.plain->region;
  } else {
    cues.plain_sigmas = cues.plain_light = cues.plain_off_hue = cv::Mat::zeros(size, CV_32FC1);
    cues.on_plain_table = cv::Mat::zeros(size, CV_8UC1);
  }
  cues.first_guess = view.first_guess.empty() ? cv::Mat::zeros(size, CV_8UC1) : view.first_guess;
  cv::connectedComponents(cues.first_guess, cues.guess_piece, 8, CV_32S);
  cues.raised_piece = cv::Mat::zeros(size, CV_32SC1);
  for (std::size_t i = 0; i < view.raised.size(); ++i) {
    cues.raised_piece.setTo(static_cast<int>(i) + 1, view.raised[i].seeds);
  }
  cues.point_m = points_of(cues.disparity_px, camera);
  cues.table_likeness = likeness_to(ground, cues.image);

  constexpr double widest_px = 800, wanted_px = 640;
  if (size.width > widest_px) {
    const double scale = wanted_px / size.width;
    cv::resize(cues.image, cues.image, {}, scale, scale, cv::INTER_AREA);
    for (cv::Mat* map :
         {&cues.residual_px, &cues.sigma_px, &cues.dense_px, &cues.height_m, &cues.dense_height_m,
          &cues.disparity_px, &cues.point_m, &cues.table_misfit, &cues.inside_table_m, &cues.table_likeness,
          &cues.plain_sigmas, &cues.plain_light, &cues.plain_off_hue, &cues.on_plain_table, &cues.first_guess,
          &cues.guess_piece, &cues.raised_piece}) {
      cv::Mat small;
      cv::resize(*map, small, cues.image.size(), 0, 0, cv::INTER_NEAREST);
      *map = small;
    }
  }
  cv::Mat smooth;
  cv::GaussianBlur(cues.image, smooth, {0, 0}, 1);
  cv::cvtColor(smooth, cues.lab, cv::COLOR_BGR2Lab);
  cues.lab.convertTo(cues.lab, CV_32F);
  return cues;
}

}  // namespace graspctx::detail
