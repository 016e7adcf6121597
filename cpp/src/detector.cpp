#include "graspctx/detector.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <opencv2/imgproc.hpp>
#include <system_error>
#include <thread>

#include "detail/check.hpp"
#include "detail/pair_checks.hpp"
#include "detail/segment_disparity.hpp"

namespace graspctx {

namespace {

using Timings = std::vector<std::pair<std::string, double>>;

void add_time(Timings& timings_ms, const std::string& stage, double time_ms) {
  const auto entry = std::find_if(timings_ms.begin(), timings_ms.end(),
                                  [&](const auto& timing) { return timing.first == stage; });
  if (entry == timings_ms.end()) {
    timings_ms.emplace_back(stage, time_ms);
  } else {
    entry->second += time_ms;
  }
}

/// Adds the time since its last call to a named stage.
class StageClock {
 public:
  explicit StageClock(Timings& timings_ms) : timings_ms_(timings_ms) {}
  void stage_done(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    add_time(timings_ms_, stage, std::chrono::duration<double, std::milli>(now - last_).count());
    last_ = now;
  }

 private:
  Timings& timings_ms_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// One view of an object, ready to be asked for the probability of any patch.
struct DescribedView {
  Contour contour;
  FeatureMatrix contexts;
};

DescribedView describe(const FovealView& view, const DescriptorOptions& options) {
  DescribedView described;
  described.contour = sample_contour(view.image, view.mask, options.contour);
  const Contour& contour = described.contour;
  described.contexts =
      shape_contexts(contour.points, options.shape_context, contour.gradients_rad, contour.border_px);
  return described;
}

/// P(g = 1 | D) at an arbitrary place of a view; nothing where there is no contour.
std::optional<double> probability_at(const DescribedView& view, const Eigen::Vector2d& view_px,
                                     const GraspModel& model) {
  const cv::Point2f centre_px(static_cast<float>(view_px.x()), static_cast<float>(view_px.y()));
  const auto feature = patch_descriptor_at(view.contour, view.contexts, centre_px, model.descriptor);
  if (!feature) return std::nullopt;
  return model.predict_probability(*feature)[0];
}

/// The middle of the object's pixels in a patch, in the full-size image: the contour that makes a patch
/// probable often runs along its border. The patch's centre if the object is not in it.
Eigen::Vector2d on_object(const FovealView& view, int patch_px, const Eigen::Vector2d& centre_px) {
  const cv::Rect patch =
      cv::Rect(static_cast<int>(std::lround(centre_px.x() - 0.5 * patch_px + 0.5)),
               static_cast<int>(std::lround(centre_px.y() - 0.5 * patch_px + 0.5)), patch_px, patch_px) &
      cv::Rect({0, 0}, view.mask.size());
  const cv::Moments moments = cv::moments(view.mask(patch), /*binaryImage=*/true);
  if (moments.m00 == 0) return view.image_from_view(centre_px);
  return view.image_from_view({patch.x + moments.m10 / moments.m00, patch.y + moments.m01 / moments.m00});
}

/// Everything about one hypothesis: foveal view, response, grasp points, pose, grasps.
DetectedObject detect_on_object(const ObjectHypothesis& hypothesis, const Detection& scene,
                                const StereoCamera& camera, const GraspModel& model,
                                const DetectorOptions& options, Timings& timings_ms) {
  StageClock clock(timings_ms);
  DetectedObject object;
  object.id = hypothesis.id;
  object.bounding_box_px = hypothesis.bounding_box_px;
  object.centroid_px = hypothesis.centroid_px;

  // III-A: each hypothesis is fixated in turn.
  const cv::Mat mask = scene.segmentation.instance_ids == hypothesis.id;
  const auto fovea = foveal_pair(scene.pair, mask, scene.disparity.dense, model.descriptor.fovea);
  clock.stage_done("fovea");
  if (!fovea) return object;

  // III-B: the contour and its shape contexts in both views; the patches of the left one.
  const Contour contour = sample_contour(fovea->left.image, fovea->left.mask, model.descriptor.contour);
  PatchDescriptors patches = patch_descriptors(contour, fovea->left.image.size(), model.descriptor);
  const DescribedView right = describe(fovea->right, model.descriptor);
  clock.stage_done("descriptors");

  // III-C: how probable each patch is a grasping point.
  const Eigen::VectorXd probabilities = model.predict_probability(patches.features);
  clock.stage_done("classifier");

  // III-D: the best local maxima, found again in the right view and classified there too.
  const std::vector<GraspPoint> points = find_grasp_points(patches, probabilities, options.grasp_points);
  object.pose = estimate_object_pose(*fovea, mask, scene.disparity.dense, camera, scene.segmentation.table);
  clock.stage_done("pose");
  const int patch_px = model.descriptor.patch.patch_px;
  for (const GraspPoint& point : points) {
    if (!object.pose) break;
    const Eigen::Vector2d view_px(point.centre_px.x, point.centre_px.y);
    const Eigen::Vector2d left_px = fovea->left.image_from_view(view_px);
    const int half_patch_px = std::max(1, static_cast<int>(patch_px / (2 * fovea->left.scale)));
    const double prior_px = detail::median_disparity(mask, scene.disparity.dense, left_px, half_patch_px);
    const auto match = match_patch(*fovea, view_px, prior_px, options.stereo_match);
    if (!match) continue;
    const auto probability_right = probability_at(right, match->right_view_px, model);
    if (!probability_right) continue;
    GraspConfiguration grasp =
        configure_grasp(on_object(fovea->left, patch_px, view_px), *match, mask, camera, *object.pose,
                        scene.segmentation.table, options.hand, options.approach_threshold);
    grasp.patch = point.patch;
    grasp.probability_left = point.probability;
    grasp.probability_right = *probability_right;
    grasp.probability = grasp.probability_left * grasp.probability_right;  // Eq. 1
    const bool possible = grasp.probability >= options.min_probability && grasp.cam_from_hand.allFinite();
    if (possible) object.grasps.push_back(std::move(grasp));
  }

  // Eq. 2: the best is the arg max; what the hand cannot do comes last.
  std::stable_sort(object.grasps.begin(), object.grasps.end(),
                   [](const GraspConfiguration& a, const GraspConfiguration& b) {
                     return a.feasible != b.feasible ? a.feasible : a.probability > b.probability;
                   });
  if (object.grasps.size() > static_cast<std::size_t>(options.max_grasps)) {
    object.grasps.resize(static_cast<std::size_t>(options.max_grasps));
  }
  for (std::size_t i = 0; i < object.grasps.size(); ++i) object.grasps[i].rank = static_cast<int>(i) + 1;
  object.intermediates = {*fovea, contour, std::move(patches), probabilities};
  clock.stage_done("grasps");
  return object;
}

/// The hypotheses do not know of each other: any number of threads gives the same.
void detect_on_each_object(Detection& detection, const StereoCamera& camera, const GraspModel& model,
                           const DetectorOptions& options) {
  const std::vector<ObjectHypothesis>& hypotheses = detection.segmentation.objects;
  std::vector<DetectedObject> objects(hypotheses.size());
  std::vector<Timings> timings_ms(hypotheses.size());
  std::vector<std::exception_ptr> failures(hypotheses.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < hypotheses.size(); i = next++) {
      try {
        objects[i] = detect_on_object(hypotheses[i], detection, camera, model, options, timings_ms[i]);
      } catch (...) {
        failures[i] = std::current_exception();
      }
    }
  };
  std::vector<std::thread> helpers;
  const std::size_t wanted = std::min(static_cast<std::size_t>(options.threads), hypotheses.size());
  try {
    for (std::size_t i = 1; i < wanted; ++i) helpers.emplace_back(work);
  } catch (const std::system_error&) {
    // The system gives no more threads: those that run do all the work.
  }
  work();
  for (std::thread& helper : helpers) helper.join();
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
  for (const auto& object_timings_ms : timings_ms) {
    for (const auto& [stage, time_ms] : object_timings_ms) add_time(detection.timings_ms, stage, time_ms);
  }
  detection.objects = std::move(objects);
}

/// The best grasp an object has to offer; objects without one come last.
std::pair<int, double> best_grasp(const DetectedObject& object) {
  if (object.grasps.empty()) return {0, 0.0};
  return {object.grasps.front().feasible ? 2 : 1, object.grasps.front().probability};
}

}  // namespace

void DetectorOptions::check() const {
  disparity.check();
  segmentation.check();
  grasp_points.check();
  stereo_match.check();
  hand.check();
  detail::require_option(std::isfinite(approach_threshold) && approach_threshold >= 0,
                         "approach_threshold must not be negative");
  detail::require_option(min_probability >= 0 && min_probability <= 1, "min_probability must be 0 to 1");
  detail::require_option(max_grasps >= 1 && max_grasps <= 1000, "max_grasps must be 1 to 1000");
  detail::require_option(threads >= 1 && threads <= 256, "threads must be 1 to 256");
}

Detection detect_grasps(const cv::Mat& left, const cv::Mat& right, const StereoCamera& camera,
                        const GraspModel& model, const DetectorOptions& options, const cv::Mat& mask) {
  options.check();
  camera.check();
  model.check();
  Detection detection;
  StageClock clock(detection.timings_ms);

  // II: a rectified pair and its disparity
  detection.pair = rectify(left, right, camera);
  detection.image_size = detection.pair.left.size();
  clock.stage_done("rectify");
  detection.disparity = compute_disparity(detection.pair, options.disparity);
  clock.stage_done("disparity");

  // III-A: what makes an object in this scene
  if (mask.empty()) {
    detection.segmentation =
        segment_objects(detection.pair, detection.disparity, camera, options.segmentation);
  } else {
    detection.segmentation = segmentation_from_mask(mask, detection.image_size);
    detection.segmentation.table =
        fit_table_plane(detection.pair, detection.disparity, camera, options.segmentation);
    // The caller knows that there are objects; what the views are worth is said all the same.
    const detail::PairChecks checks =
        detail::check_pair(detection.pair, detection.disparity, options.segmentation.min_reliable_share);
    detection.segmentation.vertical_offset_px = checks.vertical_offset_px;
    detection.segmentation.warnings = checks.warnings;
    if (checks.refusal) detection.segmentation.warnings.push_back(*checks.refusal);
  }
  detection.warnings = detection.segmentation.warnings;
  clock.stage_done("segmentation");

  // III: the peripheral view at half resolution, the foveal ones at full resolution
  detection.disparity = refine_disparity(detection.pair, detection.disparity,
                                         detection.segmentation.instance_ids, options.disparity);
  clock.stage_done("refined_disparity");

  // III-B to III-D: each hypothesis on its own
  detect_on_each_object(detection, camera, model, options);
  std::stable_sort(
      detection.objects.begin(), detection.objects.end(),
      [](const DetectedObject& a, const DetectedObject& b) { return best_grasp(a) > best_grasp(b); });
  return detection;
}

}  // namespace graspctx
