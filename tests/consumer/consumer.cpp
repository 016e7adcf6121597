// The files' library: a calibration is read, an image makes the round trip, a missing file is refused.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <graspctx/graspctx.hpp>
#include <graspctx/io/calibration_file.hpp>
#include <graspctx/io/image_file.hpp>
#include <iostream>
#include <opencv2/core.hpp>

namespace {

void expect(bool holds, const char* what) {
  if (holds) return;
  std::cerr << "failed: " << what << '\n';
  std::exit(EXIT_FAILURE);
}

}  // namespace

int main() {
  std::ofstream("calib.txt") << "cam0=[600 0 319.5; 0 600 239.5; 0 0 1]\n"
                                "cam1=[600 0 329.5; 0 600 239.5; 0 0 1]\n"
                                "doffs=10\nbaseline=80\nwidth=640\nheight=480\nndisp=128\n";
  const graspctx::StereoCamera camera = graspctx::load_calibration({"calib.txt"});
  expect(camera.focal_px == 600 && camera.doffs_px == 10, "the numbers of the file");
  expect(std::abs(camera.baseline_m - 0.08) < 1e-12, "millimetres become metres");

  cv::Mat image(48, 64, CV_8UC3);
  cv::randu(image, 0, 256);
  graspctx::write_image("image.png", image);
  const cv::Mat again = graspctx::read_image("image.png");
  expect(again.size() == image.size() && cv::norm(image, again, cv::NORM_INF) == 0, "the same pixels again");

  try {
    graspctx::read_image("missing.png");
  } catch (const graspctx::InvalidInput& refusal) {
    expect(std::string(refusal.what()).find("missing.png") != std::string::npos,
           "the message names the file");
    return EXIT_SUCCESS;
  }
  expect(false, "a missing file is refused with InvalidInput");
}
