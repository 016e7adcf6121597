#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "graspctx/error.hpp"
#include "graspctx/stereo.hpp"
#include "ray_cast.hpp"
#include "synthetic.hpp"

namespace graspctx {
namespace {

using testing::Box;
using testing::CastScene;

CastScene box_scene() {
  return testing::cast_scene(testing::test_camera(), {Box{{0, 0, 0.04}, {0.06, 0.04, 0.04}, 0.5}});
}

struct DisparityErrors {
  double known_share = 0;  // of the pixels that both views see
  double bad_share = 0;    // of the known ones: over 1 px wrong
  double median_px = 0;
};

DisparityErrors compare(const cv::Mat& disparity, const cv::Mat& truth, const cv::Rect& region) {
  std::vector<double> errors;
  int both = 0, bad = 0;
  for (int v = region.y; v < region.br().y; ++v) {
    for (int u = region.x; u < region.br().x; ++u) {
      const float true_px = truth.at<float>(v, u);
      if (std::isnan(true_px) || static_cast<float>(u) - true_px < 0) continue;
      ++both;
      const float px = disparity.at<float>(v, u);
      if (std::isnan(px)) continue;
      errors.push_back(std::abs(px - true_px));
      bad += errors.back() > 1 ? 1 : 0;
    }
  }
  DisparityErrors result;
  result.known_share = both > 0 ? static_cast<double>(errors.size()) / both : 0;
  if (errors.empty()) return result;
  result.bad_share = static_cast<double>(bad) / static_cast<double>(errors.size());
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  result.median_px = errors[errors.size() / 2];
  return result;
}

cv::Rect whole(const cv::Mat& image) {
  return {0, 0, image.cols, image.rows};
}

bool same_bytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && a.isContinuous() && b.isContinuous() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

template <typename Call>
std::string message_of(const Call& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(Stereo, DisparityOfACastSceneIsNearTheTruth) {
  const CastScene scene = box_scene();
  const Disparity disparity = compute_disparity(scene.pair);
  const DisparityErrors reliable = compare(disparity.reliable, scene.disparity, whole(scene.disparity));
  EXPECT_GT(reliable.known_share, 0.8);
  EXPECT_LT(reliable.bad_share, 0.03);
  EXPECT_LT(reliable.median_px, 0.3);
  const DisparityErrors dense = compare(disparity.dense, scene.disparity, whole(scene.disparity));
  EXPECT_GE(dense.known_share, reliable.known_share);

  DisparityOptions full;
  full.half_resolution = false;
  const Disparity fine = compute_disparity(scene.pair, full);
  const DisparityErrors fine_reliable = compare(fine.reliable, scene.disparity, whole(scene.disparity));
  EXPECT_LT(fine_reliable.median_px, reliable.median_px);
}

TEST(Stereo, ObjectsAreRefinedAtFullResolutionAndNothingElse) {
  const CastScene scene = box_scene();
  const cv::Rect box = cv::boundingRect(scene.instance_ids);
  const Disparity coarse = compute_disparity(scene.pair);
  const Disparity fine = refine_disparity(scene.pair, coarse, scene.instance_ids);
  cv::Mat truth = scene.disparity.clone();
  truth.setTo(std::numeric_limits<float>::quiet_NaN(), scene.instance_ids == 0);
  for (const auto& [before, after] :
       {std::pair(coarse.dense, fine.dense), {coarse.reliable, fine.reliable}}) {
    const DisparityErrors old_errors = compare(before, truth, box), errors = compare(after, truth, box);
    EXPECT_LT(errors.median_px, 0.7 * old_errors.median_px);
    EXPECT_LE(errors.bad_share, old_errors.bad_share);
    EXPECT_GE(errors.known_share, old_errors.known_share);
    cv::Mat outside_before = before.clone(), outside_after = after.clone();
    outside_before.setTo(0, scene.instance_ids);
    outside_after.setTo(0, scene.instance_ids);
    EXPECT_TRUE(same_bytes(outside_before, outside_after));
  }
}

TEST(Stereo, AnObjectAtTheLeftBorderIsRefinedFromThePixelsBesideIt) {
  // The table 100 px further left in both views: the right view's half of a match lies outside of the region.
  const CastScene scene = box_scene();
  const cv::Rect box = cv::boundingRect(scene.instance_ids);
  const int shift_px = box.x - 80;
  const auto moved = [&](const cv::Mat& image) {
    cv::Mat result;
    cv::copyMakeBorder(image(cv::Rect(shift_px, 0, image.cols - shift_px, image.rows)).clone(), result, 0, 0,
                       0, shift_px, cv::BORDER_REPLICATE);
    return result;
  };
  const RectifiedPair pair{moved(scene.pair.left), moved(scene.pair.right)};
  const cv::Mat ids = moved(scene.instance_ids), truth = moved(scene.disparity);
  const Disparity coarse = compute_disparity(pair);
  const Disparity fine = refine_disparity(pair, coarse, ids);
  const cv::Rect region = cv::boundingRect(ids);
  EXPECT_GT(compare(fine.dense, truth, region).known_share, 0.9);
  EXPECT_LT(compare(fine.dense, truth, region).median_px, compare(coarse.dense, truth, region).median_px);
}

TEST(Stereo, RefiningLeavesAloneWhatIsFineOrEmptyAndRefusesOtherSizes) {
  const CastScene scene = box_scene();
  DisparityOptions full;
  full.half_resolution = false;
  const Disparity fine = compute_disparity(scene.pair, full);
  EXPECT_TRUE(same_bytes(refine_disparity(scene.pair, fine, scene.instance_ids, full).dense, fine.dense));
  const cv::Mat nothing = cv::Mat::zeros(480, 640, CV_8UC1);
  EXPECT_TRUE(same_bytes(refine_disparity(scene.pair, fine, nothing).dense, fine.dense));
  Disparity unknown{fine.dense.clone(), fine.reliable.clone()};
  unknown.dense.setTo(std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(
      same_bytes(refine_disparity(scene.pair, unknown, scene.instance_ids).reliable, unknown.reliable));
  EXPECT_THROW(refine_disparity(scene.pair, fine, cv::Mat::zeros(48, 64, CV_8UC1)), InvalidInput);
  EXPECT_THROW(refine_disparity(scene.pair, {fine.dense, {}}, nothing), InvalidInput);
  EXPECT_THROW(refine_disparity({scene.pair.left, {}}, fine, nothing), InvalidInput);
}

TEST(Stereo, ColumnsWithinTheSearchRangeAreMatchedToo) {
  // 160 px are searched, the table's disparity is about 70: without padding the first 160 columns are empty.
  const CastScene scene = box_scene();
  const Disparity disparity = compute_disparity(scene.pair);
  const DisparityErrors left = compare(disparity.reliable, scene.disparity, {0, 0, 160, 480});
  EXPECT_GT(left.known_share, 0.6);
  EXPECT_LT(left.bad_share, 0.05);
}

TEST(Stereo, NothingIsKnownWhereTheMatchLiesOutsideTheRightView) {
  const Disparity disparity = compute_disparity(box_scene().pair);
  for (int v = 0; v < disparity.dense.rows; ++v) {
    for (int u = 0; u < 20; ++u) {
      const float px = disparity.dense.at<float>(v, u);
      EXPECT_TRUE(std::isnan(px) || px <= static_cast<float>(u) + 2) << u << ", " << v;
    }
  }
}

TEST(Stereo, PlainSurfacesAreNotReliable) {
  CastScene scene = box_scene();
  std::mt19937 generator(3);
  for (cv::Mat* view : {&scene.pair.left, &scene.pair.right}) {
    for (int v = 0; v < 200; ++v) {
      for (int u = 0; u < view->cols; ++u) {
        const double grey = 128 + 3 * (testing::uniform(generator) - 0.5);
        view->at<cv::Vec3b>(v, u) = cv::Vec3b::all(cv::saturate_cast<uchar>(grey));
      }
    }
  }
  const Disparity disparity = compute_disparity(scene.pair);
  const cv::Rect plain(100, 10, 500, 170), textured(200, 230, 400, 230);
  EXPECT_LT(compare(disparity.reliable, scene.disparity, plain).known_share, 0.05);
  EXPECT_GT(compare(disparity.reliable, scene.disparity, textured).known_share, 0.8);
}

TEST(Stereo, SwappedViewsHaveNoReliableDisparity) {
  const CastScene scene = box_scene();
  const Disparity disparity = compute_disparity({scene.pair.right, scene.pair.left});
  const double share =
      cv::countNonZero(disparity.reliable == disparity.reliable) / static_cast<double>(640 * 480);
  EXPECT_LT(share, 0.2);
}

TEST(Stereo, ShiftingTheRightViewShiftsTheDisparity) {
  const CastScene scene = box_scene();
  constexpr int shift_px = 8;
  cv::Mat moved;
  cv::warpAffine(scene.pair.right, moved, cv::Matx23d(1, 0, -shift_px, 0, 1, 0), scene.pair.right.size());
  const Disparity before = compute_disparity(scene.pair);
  const Disparity after = compute_disparity({scene.pair.left, moved});
  int both = 0, alike = 0;
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const float difference = after.reliable.at<float>(v, u) - before.reliable.at<float>(v, u);
      if (std::isnan(difference)) continue;
      ++both;
      alike += std::abs(difference - shift_px) < 0.25 ? 1 : 0;
    }
  }
  EXPECT_GT(both, 150000);
  EXPECT_GT(alike, 0.97 * both);
}

TEST(Stereo, ABrighterRightViewChangesLittle) {
  const CastScene scene = box_scene();
  cv::Mat brighter;
  scene.pair.right.convertTo(brighter, -1, 1.05);
  const Disparity disparity = compute_disparity({scene.pair.left, brighter});
  EXPECT_GT(compare(disparity.reliable, scene.disparity, whole(scene.disparity)).known_share, 0.75);
}

TEST(Stereo, TheSameBytesForAnyNumberOfThreads) {
  const RectifiedPair pair = box_scene().pair;
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  const Disparity one = compute_disparity(pair);
  for (const int threads : {2, 3, 8}) {
    cv::setNumThreads(threads);
    const Disparity several = compute_disparity(pair);
    EXPECT_TRUE(same_bytes(one.dense, several.dense)) << threads;
    EXPECT_TRUE(same_bytes(one.reliable, several.reliable)) << threads;
  }
  cv::setNumThreads(before);
}

TEST(Stereo, GreyImagesAndOddSizesWork) {
  const CastScene scene = box_scene();
  RectifiedPair grey;
  cv::cvtColor(scene.pair.left(cv::Rect(0, 0, 637, 479)), grey.left, cv::COLOR_BGR2GRAY);
  cv::cvtColor(scene.pair.right(cv::Rect(0, 0, 637, 479)), grey.right, cv::COLOR_BGR2GRAY);
  const Disparity disparity = compute_disparity(grey);
  ASSERT_EQ(disparity.reliable.size(), cv::Size(637, 479));
  ASSERT_EQ(disparity.reliable.type(), CV_32FC1);
  const DisparityErrors errors = compare(disparity.reliable, scene.disparity, {0, 0, 637, 479});
  EXPECT_GT(errors.known_share, 0.75);
  EXPECT_LT(errors.median_px, 0.4);
}

// The world at infinity as a smooth picture on the rays of the rectified camera.
double brightness_along(const Eigen::Vector3d& ray) {
  const double x = ray.x() / ray.z(), y = ray.y() / ray.z();
  return 128 + 60 * std::sin(9 * x + 4 * y) + 50 * std::cos(13 * y - 5 * x);
}

cv::Mat raw_image(const RawView& view, const cv::Size& size) {
  cv::Matx33d camera;
  for (int i = 0; i < 9; ++i) camera.val[i] = view.camera_matrix(i / 3, i % 3);
  std::vector<cv::Point2d> pixels, rays;
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) pixels.emplace_back(u, v);
  }
  // The inverse of the mapping under test, by OpenCV's other route: iteration from the raw pixel.
  if (view.distortion_model == RawView::Distortion::plumb_bob) {
    cv::undistortPoints(pixels, rays, camera, view.distortion);
  } else {
    cv::fisheye::undistortPoints(pixels, rays, camera, view.distortion);
  }
  cv::Mat image(size, CV_8UC1);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Vector3d ray = view.rectified_from_raw * Eigen::Vector3d(rays[i].x, rays[i].y, 1);
    image.data[i] = cv::saturate_cast<uchar>(brightness_along(ray));
  }
  return image;
}

TEST(Stereo, RawViewsAreUndistortedAndTurned) {
  const cv::Size size(320, 240);
  for (const auto model : {RawView::Distortion::plumb_bob, RawView::Distortion::equidistant}) {
    StereoCamera camera;
    camera.focal_px = 300;
    camera.centre_px = {158, 121};
    camera.baseline_m = 0.1;
    camera.doffs_px = 6;
    camera.width_px = size.width;
    camera.height_px = size.height;
    RawView left, right;
    left.distortion_model = right.distortion_model = model;
    left.camera_matrix << 290, 0, 161, 0, 292, 118, 0, 0, 1;
    right.camera_matrix << 296, 0, 155, 0, 295, 123, 0, 0, 1;
    const bool plumb_bob = model == RawView::Distortion::plumb_bob;
    left.distortion = plumb_bob ? std::vector<double>{-0.2, 0.05, 0.001, -0.002, 0}
                                : std::vector<double>{0.03, -0.01, 0.002, 0};
    right.distortion =
        plumb_bob ? std::vector<double>{-0.18, 0.04, 0, 0} : std::vector<double>{0.02, 0.01, 0, 0};
    left.rectified_from_raw = Eigen::AngleAxisd(0.03, Eigen::Vector3d(1, 2, -1).normalized());
    right.rectified_from_raw = Eigen::AngleAxisd(0.04, Eigen::Vector3d(-1, 1, 1).normalized());
    camera.raw = std::array<RawView, 2>{left, right};
    const RectifiedPair pair = rectify(raw_image(left, size), raw_image(right, size), camera);
    for (const bool is_left : {true, false}) {
      const cv::Mat& view = is_left ? pair.left : pair.right;
      const double centre_u = camera.centre_px.x() + (is_left ? 0 : camera.doffs_px);
      for (int v = 40; v < 200; v += 7) {
        for (int u = 50; u < 270; u += 7) {
          const Eigen::Vector3d ray((u - centre_u) / 300, (v - 121) / 300.0, 1);
          EXPECT_NEAR(view.at<uchar>(v, u), brightness_along(ray), 2.5) << u << ", " << v << ", " << is_left;
        }
      }
    }
  }
}

TEST(Stereo, RectifiedImagesPassUnchanged) {
  const CastScene scene = box_scene();
  const RectifiedPair pair = rectify(scene.pair.left, scene.pair.right, testing::test_camera());
  EXPECT_TRUE(same_bytes(pair.left, scene.pair.left));
  EXPECT_TRUE(same_bytes(pair.right, scene.pair.right));
}

TEST(Stereo, BadImagesAreNamed) {
  const StereoCamera camera = testing::test_camera();
  const cv::Mat good(480, 640, CV_8UC3, cv::Scalar::all(100));
  const auto rectifying = [&](const cv::Mat& left, const cv::Mat& right) {
    return message_of([&] { rectify(left, right, camera); });
  };
  EXPECT_NE(rectifying({}, good).find("left image"), std::string::npos);
  EXPECT_NE(rectifying(good, {}).find("right image"), std::string::npos);
  EXPECT_NE(rectifying(cv::Mat(480, 640, CV_16UC1), good).find("CV_16UC1"), std::string::npos);
  EXPECT_NE(rectifying(good, cv::Mat(480, 640, CV_32FC3)).find("CV_32FC3"), std::string::npos);
  EXPECT_NE(rectifying(good, cv::Mat(480, 638, CV_8UC3)).find("638x480"), std::string::npos);
  EXPECT_NE(rectifying(good, cv::Mat(480, 640, CV_8UC1)).find("CV_8UC1"), std::string::npos);
  const cv::Mat small(240, 320, CV_8UC3, cv::Scalar::all(100));
  EXPECT_NE(rectifying(small, small).find("640x480"), std::string::npos);
  StereoCamera bad = camera;
  bad.focal_px = -1;
  EXPECT_THROW(rectify(good, good, bad), InvalidInput);
  EXPECT_THROW(compute_disparity({good, {}}), InvalidInput);
  EXPECT_THROW(compute_disparity({good, small}), InvalidInput);
  EXPECT_THROW(compute_disparity({cv::Mat(480, 640, CV_16UC1), cv::Mat(480, 640, CV_16UC1)}), InvalidInput);
  const cv::Mat tiny(4, 4, CV_8UC3);
  EXPECT_THROW(compute_disparity({tiny, tiny}), InvalidInput);
}

TEST(Stereo, BadOptionsAreNamed) {
  const cv::Mat good(64, 64, CV_8UC3, cv::Scalar::all(100));
  const auto message = [&](const DisparityOptions& options) {
    return message_of([&] { compute_disparity({good, good}, options); });
  };
  DisparityOptions options;
  options.max_disparity_px = -1;
  EXPECT_NE(message(options).find("max_disparity_px"), std::string::npos);
  options.max_disparity_px = 4064;
  EXPECT_EQ(message(options), "");
  options.half_resolution = false;  // the matcher cannot count so far
  EXPECT_NE(message(options).find("max_disparity_px must be between 0 and 2032"), std::string::npos);
  options = {};
  options.block_px = 4;
  EXPECT_NE(message(options).find("block_px"), std::string::npos);
  options = {};
  options.uniqueness_percent = 100;
  EXPECT_NE(message(options).find("uniqueness_percent"), std::string::npos);
  options = {};
  options.speckle_px = -1;
  EXPECT_NE(message(options).find("speckle_px"), std::string::npos);
  options = {};
  options.left_right_px = std::nan("");
  EXPECT_NE(message(options).find("left_right_px"), std::string::npos);
  options = {};
  options.texture_sigmas = -1;
  EXPECT_NE(message(options).find("texture_sigmas"), std::string::npos);
}

TEST(Stereo, ASmallImageIsMatchedWithoutComplaint) {
  const cv::Mat texture = testing::random_texture({16, 16}, 5);
  const Disparity disparity = compute_disparity({texture, texture});
  EXPECT_EQ(disparity.dense.size(), cv::Size(16, 16));
}

}  // namespace
}  // namespace graspctx
