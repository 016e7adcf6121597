#pragma once
// Images of known content for tests.
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "graspctx/camera.hpp"
#include "graspctx/stereo.hpp"

namespace graspctx::testing {

inline double uniform(std::mt19937& generator, double low = 0, double high = 1) {
  return low + (high - low) * (generator() / 4294967296.0);
}

/// A camera as on a small robot: f = 600 px, baseline 8 cm, 640×480.
inline StereoCamera test_camera() {
  StereoCamera camera;
  camera.focal_px = 600;
  camera.centre_px = {320, 240};
  camera.baseline_m = 0.08;
  camera.width_px = 640;
  camera.height_px = 480;
  return camera;
}

/// Sensor noise, so that nothing rests on perfect images.
inline void add_noise(RectifiedPair& pair, double sigma, std::uint32_t seed = 11) {
  std::mt19937 generator(seed);
  for (cv::Mat* view : {&pair.left, &pair.right}) {
    for (int i = 0; i < static_cast<int>(view->total()) * view->channels(); ++i) {
      double sum = -6;
      for (int k = 0; k < 12; ++k) sum += uniform(generator);  // nearly normal, variance 1
      view->data[i] = cv::saturate_cast<uchar>(view->data[i] + sigma * sum);
    }
  }
}

/// Smooth random colours: something for a matcher to hold on to.
inline cv::Mat random_texture(const cv::Size& size, std::uint32_t seed, double cell_px = 3) {
  std::mt19937 generator(seed);
  cv::Mat coarse(static_cast<int>(size.height / cell_px) + 2, static_cast<int>(size.width / cell_px) + 2,
                 CV_8UC3);
  for (int v = 0; v < coarse.rows; ++v) {
    for (int u = 0; u < coarse.cols; ++u) {
      for (int c = 0; c < 3; ++c) coarse.at<cv::Vec3b>(v, u)[c] = static_cast<uchar>(generator() >> 24);
    }
  }
  cv::Mat texture;
  cv::resize(coarse, texture, size, 0, 0, cv::INTER_LINEAR);
  return texture;
}

/// A drawn mug on a plain ground: body, and a handle as a ring on its right.
struct DrawnMug {
  cv::Mat image, mask, handle;
};

inline DrawnMug draw_mug(const cv::Size& size = {640, 480}, const cv::Point& at = {260, 200}, int unit = 60) {
  DrawnMug mug{cv::Mat(size, CV_8UC3, cv::Scalar(200, 190, 180)), cv::Mat::zeros(size, CV_8UC1),
               cv::Mat::zeros(size, CV_8UC1)};
  const cv::Rect body(at.x - unit, at.y - unit, 2 * unit, 2 * unit + unit / 2);
  cv::ellipse(mug.handle, {body.br().x, at.y + unit / 4}, {unit * 2 / 3, unit * 3 / 4}, 0, -85, 85,
              cv::Scalar(255), unit / 5);
  cv::rectangle(mug.handle, body, cv::Scalar(0), cv::FILLED);
  cv::rectangle(mug.mask, body, cv::Scalar(255), cv::FILLED);
  mug.mask |= mug.handle;
  mug.image.setTo(cv::Scalar(60, 80, 150), mug.mask);
  cv::rectangle(mug.image, cv::Rect(body.x + unit / 2, body.y + unit / 2, unit, unit),
                cv::Scalar(40, 150, 90), cv::FILLED);
  return mug;
}

}  // namespace graspctx::testing
