#pragma once
// Cues that say nothing but an image's colours, for tests to write into.
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "detail/scene_cues.hpp"
#include "detail/superpixels.hpp"
#include "synthetic.hpp"

namespace graspctx::testing {

inline detail::SceneCues blank_cues(const cv::Mat& image) {
  const auto filled = [&](float value) { return cv::Mat(image.size(), CV_32FC1, cv::Scalar(value)); };
  constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
  detail::SceneCues cues;
  cues.image = image;
  cv::cvtColor(image, cues.lab, cv::COLOR_BGR2Lab);
  cues.lab.convertTo(cues.lab, CV_32F);
  for (cv::Mat* map :
       {&cues.residual_px, &cues.dense_px, &cues.height_m, &cues.dense_height_m, &cues.disparity_px}) {
    *map = filled(unknown);
  }
  for (cv::Mat* map : {&cues.inside_table_m, &cues.table_likeness, &cues.plain_sigmas, &cues.plain_light,
                       &cues.plain_off_hue}) {
    *map = filled(0);
  }
  cues.sigma_px = filled(0.1F);
  cues.table_misfit = filled(-1);
  cues.point_m = cv::Mat(image.size(), CV_32FC3, cv::Scalar::all(unknown));
  cues.on_plain_table = cv::Mat::zeros(image.size(), CV_8UC1);
  cues.first_guess = cv::Mat::zeros(image.size(), CV_8UC1);
  cues.guess_piece = cv::Mat::zeros(image.size(), CV_32SC1);
  cues.raised_piece = cv::Mat::zeros(image.size(), CV_32SC1);
  return cues;
}

inline detail::SceneCues blank_cues(const cv::Size& size = {60, 40}) {
  return blank_cues(cv::Mat(size, CV_8UC3, cv::Scalar(90, 120, 150)));
}

/// Every cue a random number, or unknown at random pixels.
inline detail::SceneCues random_cues(const cv::Size& size, std::uint32_t seed) {
  std::mt19937 generator(seed);
  detail::SceneCues cues = blank_cues(random_texture(size, seed));
  cues.has_plane = cues.has_plain_table = true;
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const auto random = [&](double low, double high) {
        return static_cast<float>(uniform(generator, low, high));
      };
      const bool known = random(0, 1) < 0.6F, dense_known = random(0, 1) < 0.8F;
      if (known) cues.residual_px.at<float>(v, u) = random(-3, 25);
      if (known) cues.height_m.at<float>(v, u) = random(-0.1, 0.5);
      if (dense_known) cues.dense_px.at<float>(v, u) = random(-8, 25);
      if (dense_known) cues.dense_height_m.at<float>(v, u) = random(-0.1, 0.5);
      if (dense_known) {
        cues.disparity_px.at<float>(v, u) = random(10, 90);
        cues.point_m.at<cv::Vec3f>(v, u) = {random(-0.4, 0.4), random(-0.3, 0.3), random(0.4, 1)};
      }
      cues.sigma_px.at<float>(v, u) = random(0.01, 0.5);
      cues.table_misfit.at<float>(v, u) = random(-1, 9);
      cues.inside_table_m.at<float>(v, u) = random(-0.3, 0.3);
      cues.table_likeness.at<float>(v, u) = random(-5, 5);
      cues.plain_sigmas.at<float>(v, u) = random(0, 40);
      cues.plain_light.at<float>(v, u) = random(0, 4);
      cues.plain_off_hue.at<float>(v, u) = random(0, 4);
      cues.on_plain_table.at<uchar>(v, u) = random(0, 1) < 0.5F ? 255 : 0;
      cues.first_guess.at<uchar>(v, u) = random(0, 1) < 0.5F ? 255 : 0;
      cues.guess_piece.at<int>(v, u) = cvFloor(random(0, 4));
      cues.raised_piece.at<int>(v, u) = cvFloor(random(0, 4));
    }
  }
  return cues;
}

/// Tiles of the size given, numbered row by row.
inline detail::Superpixels tiles(const cv::Size& image, const cv::Size& tile) {
  const int columns = (image.width + tile.width - 1) / tile.width;
  const int rows = (image.height + tile.height - 1) / tile.height;
  detail::Superpixels result{cv::Mat(image, CV_32SC1), columns * rows};
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      result.labels.at<int>(v, u) = v / tile.height * columns + u / tile.width;
    }
  }
  return result;
}

/// Region 1 is the box, region 0 the rest.
inline detail::Superpixels box_and_rest(const cv::Size& image, const cv::Rect& box) {
  detail::Superpixels result{cv::Mat::zeros(image, CV_32SC1), 2};
  result.labels(box).setTo(1);
  return result;
}

}  // namespace graspctx::testing
