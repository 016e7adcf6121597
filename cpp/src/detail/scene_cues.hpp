#pragma once
#include <opencv2/core.hpp>

#include "detail/table_view.hpp"
#include "graspctx/camera.hpp"
#include "graspctx/stereo.hpp"

namespace graspctx::detail {

/// All that both views say of each pixel of the left one, side by side (III-A). Maps are CV_32FC1 unless said
/// otherwise, NaN where unknown; all of one size: the image's, but
/// 640 px wide if that has more than 800.
struct SceneCues {
  bool has_plane = false, has_plain_table = false;
  cv::Mat image;           // CV_8UC3
  cv::Mat lab;             // CV_32FC3, smoothed: 8-bit CIELAB
  cv::Mat residual_px;     // disparity over the plane's: matched over the plane
  cv::Mat sigma_px;        // its standard deviation
  cv::Mat dense_px;        // the same of the first pass, which knows more and knows it worse
  cv::Mat height_m;        // of residual_px
  cv::Mat dense_height_m;  // of dense_px
  cv::Mat disparity_px;    // the best known, over the plane or not
  cv::Mat point_m;         // CV_32FC3, camera frame
  cv::Mat table_misfit;    // how badly the plane explains what both views show, in variances; -1 unknown
  cv::Mat inside_table_m;  // how far inside the table's seen extent the pixel's foot is; < 0 outside
  cv::Mat table_likeness;  // log of how common the colour is on the ground, against all colours alike
  cv::Mat plain_sigmas;    // how far from the colour of the plain table, standard deviations; 0 without one
  cv::Mat plain_light;     // see TableComparison
  cv::Mat plain_off_hue;
  cv::Mat on_plain_table;  // CV_8UC1, 255 within its extent
  cv::Mat first_guess;     // CV_8UC1, see TableView
  // CV_32SC1, 0 = none: connected parts of the first guess, and the objects of TableView::raised.
  cv::Mat guess_piece, raised_piece;
};

SceneCues scene_cues(const RectifiedPair& pair, const Disparity& disparity, const StereoCamera& camera,
                     const TableView& view);

}  // namespace graspctx::detail
