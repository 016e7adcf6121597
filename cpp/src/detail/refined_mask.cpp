#include "detail/refined_mask.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace graspctx::detail {

namespace {

constexpr double seen_around = 0.3;  // of the mask's longer side: ground whose colours are learnt
constexpr double thick = 0.01;       // of it: what is thinner is a border that lies a pixel off
constexpr double clearer = 2;        // so much stronger are the edges that a part is taken away for
constexpr int longer_side_px = 120;  // a larger mask is cut in a smaller picture
constexpr int fewest_px = 12;        // of figure and of ground: GrabCut learns five colours of each

/// cv::grabCut draws the first centres of its colours from OpenCV's generator: the same ones every time, and
/// the generator is left as it was.
class SameRandomNumbers {
 public:
  SameRandomNumbers() : before_(cv::theRNG()) { cv::theRNG() = cv::RNG(1); }
  ~SameRandomNumbers() { cv::theRNG() = before_; }
  SameRandomNumbers(const SameRandomNumbers&) = delete;
  SameRandomNumbers& operator=(const SameRandomNumbers&) = delete;

 private:
  cv::RNG before_;
};

/// The mask's pixels that look like what is outside it.
cv::Mat ground_by_colour(const cv::Mat& picture, const cv::Mat& mask) {
  const int figure_px = cv::countNonZero(mask), around_px = mask.size().area() - figure_px;
  if (figure_px < fewest_px || around_px < fewest_px) return cv::Mat::zeros(mask.size(), CV_8UC1);
  cv::Mat labels(mask.size(), CV_8UC1, cv::Scalar(cv::GC_BGD));
  labels.setTo(cv::GC_PR_FGD, mask);
  cv::Mat ground_colours, figure_colours;
  constexpr int iterations = 2;
  const SameRandomNumbers same;
  cv::grabCut(picture, labels, {}, ground_colours, figure_colours, iterations, cv::GC_INIT_WITH_MASK);
  return mask & (labels != cv::GC_PR_FGD);
}

/// The same at a size that bounds its time.
cv::Mat ground_in_mask(const cv::Mat& image, const cv::Mat& mask, int side_px) {
  cv::Mat picture = image, small_mask = mask;
  if (image.channels() == 1) cv::cvtColor(image, picture, cv::COLOR_GRAY2BGR);
  if (side_px <= longer_side_px) return ground_by_colour(picture, small_mask);
  const double scale = static_cast<double>(longer_side_px) / side_px;
  cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  cv::resize(mask, small_mask, picture.size(), 0, 0, cv::INTER_NEAREST);
  cv::Mat ground = ground_by_colour(picture, small_mask);
  cv::resize(ground, ground, mask.size(), 0, 0, cv::INTER_LINEAR);
  return mask & (ground >= 128);
}

/// How strong the edges of an image are, CV_32FC1: the largest Sobel gradient of its channels nearby.
cv::Mat edge_strength(const cv::Mat& image) {
  std::vector<cv::Mat> channels;
  cv::split(image, channels);
  cv::Mat strength(image.size(), CV_32FC1, cv::Scalar(0));
  for (const cv::Mat& channel : channels) {
    cv::Mat du, dv, magnitude;
    cv::Sobel(channel, du, CV_32F, 1, 0);
    cv::Sobel(channel, dv, CV_32F, 0, 1);
    cv::magnitude(du, dv, magnitude);
    strength = cv::max(strength, magnitude);
  }
  cv::dilate(strength, strength, {});  // a border may lie a pixel off
  return strength;
}

/// The pixels of a part that touch what another mask holds.
cv::Mat border_to(const cv::Mat& part, const cv::Mat& other) {
  cv::Mat reached;
  cv::dilate(other, reached, {});
  return reached & part;
}

cv::Mat without_thin_parts(const cv::Mat& mask, int side_px) {
  const int disc_px = 2 * std::max(1, static_cast<int>(std::lround(thick * side_px))) + 1;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {disc_px, disc_px});
  cv::Mat parts;
  cv::morphologyEx(mask, parts, cv::MORPH_OPEN, disc);
  cv::dilate(parts, parts, disc);
  return parts & mask;
}

}  // namespace

cv::Mat refined_mask(const cv::Mat& image, const cv::Mat& mask) {
  cv::Mat refined = mask > 0;
  const cv::Rect box = cv::boundingRect(refined);
  const int side_px = std::max(box.width, box.height);
  const int around_px = static_cast<int>(seen_around * side_px) + 8;
  const cv::Rect around(box.x - around_px, box.y - around_px, box.width + 2 * around_px,
                        box.height + 2 * around_px);
  const cv::Rect region = around & cv::Rect({0, 0}, image.size());
  const cv::Mat given = refined(region).clone();
  const cv::Mat ground = ground_in_mask(image(region), given, side_px);
  const cv::Mat figure = given & ~ground, outside = ~given;
  if (cv::countNonZero(figure) < fewest_px) return refined;

  // The given border stays wherever it follows the image's edges as well as the new one.
  const cv::Mat edges = edge_strength(image(region));
  cv::Mat part_of;
  const int count = cv::connectedComponents(without_thin_parts(ground, side_px), part_of);
  for (int i = 1; i < count; ++i) {
    const cv::Mat part = part_of == i;
    const cv::Mat to_outside = border_to(part, outside), to_figure = border_to(part, figure);
    if (cv::countNonZero(to_figure) == 0) continue;
    const bool enclosed = cv::countNonZero(to_outside) == 0;  // by the figure: ground seen through it
    if (enclosed || cv::mean(edges, to_figure)[0] > clearer * cv::mean(edges, to_outside)[0]) {
      refined(region).setTo(0, part);
    }
  }
  return refined;
}

}  // namespace graspctx::detail
