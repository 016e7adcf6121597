// The core library alone: camera, contour, shape contexts and patch descriptors of a drawn ring.
#include <cmath>
#include <cstdlib>
#include <graspctx/graspctx.hpp>
#include <iostream>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace {

void expect(bool holds, const char* what) {
  if (holds) return;
  std::cerr << "failed: " << what << '\n';
  std::exit(EXIT_FAILURE);
}

}  // namespace

int main() {
  graspctx::StereoCamera camera;
  camera.focal_px = 600;
  camera.centre_px = {319.5, 239.5};
  camera.baseline_m = 0.08;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.check();
  const Eigen::Vector3d point_m{0.05, -0.02, 0.7};
  const Eigen::Vector3d again_m =
      camera.triangulate(camera.project(point_m), camera.disparity_px(point_m.z()));
  expect((again_m - point_m).norm() < 1e-12, "triangulation undoes projection");

  // The exception's type has to survive the way out of the shared library.
  camera.baseline_m = std::numeric_limits<double>::quiet_NaN();
  bool refused = false;
  try {
    camera.check();
  } catch (const graspctx::InvalidInput&) {
    refused = true;
  }
  expect(refused, "a baseline of NaN is refused with InvalidInput");

  cv::Mat image(280, 280, CV_8UC1, cv::Scalar(40)), mask(280, 280, CV_8UC1, cv::Scalar(0));
  cv::circle(image, {140, 140}, 90, cv::Scalar(200), cv::FILLED);
  cv::circle(image, {140, 140}, 50, cv::Scalar(40), cv::FILLED);
  cv::circle(mask, {140, 140}, 92, cv::Scalar(255), cv::FILLED);

  const graspctx::Contour contour = graspctx::sample_contour(image, mask);
  expect(contour.points.size() > 100, "both circles are sampled");
  for (const cv::Point2f& sample : contour.points) {
    const double radius = std::hypot(sample.x - 140, sample.y - 140);
    expect(std::abs(radius - 90) < 3 || std::abs(radius - 50) < 3, "every sample lies on a circle");
  }

  const graspctx::FeatureMatrix contexts = graspctx::shape_contexts(contour.points);
  expect(contexts.rows() == static_cast<Eigen::Index>(contour.points.size()) && contexts.cols() == 40,
         "one histogram of 40 bins for each sample");
  expect(contexts.rowwise().sum().maxCoeff() <= static_cast<float>(contour.points.size() - 1),
         "no histogram counts more than the other samples");

  const graspctx::PatchDescriptors patches = graspctx::patch_descriptors(contour, image.size());
  expect(patches.features.rows() > 0 && patches.features.cols() == 120, "descriptors have 120 numbers");
  for (Eigen::Index row = 0; row < patches.features.rows(); ++row) {
    const float length = patches.features.row(row).squaredNorm();
    expect(std::abs(length - 3) < 1e-4F, "square roots of three histograms of sum 1");
  }

  std::cout << "graspctx " << graspctx::version << ": " << patches.features.rows() << " patches\n";
  return EXIT_SUCCESS;
}
