#include "graspctx/detector.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <set>
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

/// The models that are asked, in order.
using Models = std::vector<const GraspModel*>;

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

/// An object as one kind of descriptor sees it.
struct LeftView {
  FovealPair fovea;
  Contour contour;
  PatchDescriptors patches;
};

/// For each model the left view by its descriptor options, described once for all that describe alike; null
/// where there is none.
std::vector<std::shared_ptr<const LeftView>> left_views(const Detection& scene, const cv::Mat& mask,
                                                        const Models& models, StageClock& clock) {
  std::vector<std::shared_ptr<const LeftView>> views;
  for (const GraspModel* model : models) {
    std::size_t alike = 0;
    while (alike < views.size() && !same_descriptor(*models[alike], *model)) ++alike;
    if (alike < views.size()) {
      views.push_back(views[alike]);
      continue;
    }
    views.emplace_back();
    const DescriptorOptions& descriptor = model->descriptor;
    // III-A: each hypothesis is fixated in turn.
    const auto fovea = foveal_pair(scene.pair, mask, scene.disparity.dense, descriptor.fovea);
    clock.stage_done("fovea");
    if (!fovea) continue;
    // III-B: the contour and its shape contexts, in patches.
    const Contour contour = sample_contour(fovea->left.image, fovea->left.mask, descriptor.contour);
    PatchDescriptors patches = patch_descriptors(contour, fovea->left.image.size(), descriptor);
    views.back() = std::make_shared<LeftView>(LeftView{*fovea, contour, std::move(patches)});
    clock.stage_done("descriptors");
  }
  return views;
}

/// The model that answers, and how familiar the object is to it; nothing if the models cannot tell, or if
/// they see no contour.
std::optional<ModelChoice> vote(const Models& models,
                                const std::vector<std::shared_ptr<const LeftView>>& views,
                                const DetectorOptions& options) {
  std::vector<const FeatureMatrix*> features;
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (!models[i]->familiarity || !views[i] || views[i]->patches.features.rows() == 0) return std::nullopt;
    features.push_back(&views[i]->patches.features);
  }
  const double by_default = models.size() > 1 ? default_min_familiarity : 0;
  return choose_model(models, features, options.min_familiarity.value_or(by_default));
}

/// Everything about one hypothesis: foveal view, response, grasp points, pose, grasps.
DetectedObject detect_on_object(const ObjectHypothesis& hypothesis, const Detection& scene,
                                const StereoCamera& camera, const Models& models,
                                const DetectorOptions& options, Timings& timings_ms) {
  StageClock clock(timings_ms);
  DetectedObject object;
  object.id = hypothesis.id;
  object.bounding_box_px = hypothesis.bounding_box_px;
  object.centroid_px = hypothesis.centroid_px;

  const cv::Mat mask = scene.segmentation.instance_ids == hypothesis.id;
  const auto views = left_views(scene, mask, models, clock);
  const auto choice = vote(models, views, options);
  if (choice) clock.stage_done("familiarity");
  const std::size_t answering = choice ? choice->model : 0;
  if (!views[answering]) return object;
  const auto& [fovea, contour, patches] = *views[answering];
  const GraspModel& model = *models[answering];
  if (choice) {
    object.model_name = model.name;
    object.familiarity = choice->familiarity;
    object.unfamiliar = !choice->familiar;
  }
  object.pose = estimate_object_pose(fovea, mask, scene.disparity.dense, camera, scene.segmentation.table);
  clock.stage_done("pose");
  object.intermediates = {fovea, contour, patches, {}};
  // Several models that see no contour have no answer either.
  if (object.unfamiliar || (!choice && models.size() > 1)) return object;

  // III-B: the shape contexts of the right view, too.
  const DescribedView right = describe(fovea.right, model.descriptor);
  clock.stage_done("descriptors");

  // III-C: how probable each patch is a grasping point.
  const Eigen::VectorXd probabilities = model.predict_probability(patches.features);
  clock.stage_done("classifier");

  // III-D: the best local maxima, found again in the right view and classified there too.
  const std::vector<GraspPoint> points = find_grasp_points(patches, probabilities, options.grasp_points);
  const int patch_px = model.descriptor.patch.patch_px;
  for (const GraspPoint& point : points) {
    if (!object.pose) break;
    const Eigen::Vector2d view_px(point.centre_px.x, point.centre_px.y);
    const Eigen::Vector2d left_px = fovea.left.image_from_view(view_px);
    const int half_patch_px = std::max(1, static_cast<int>(patch_px / (2 * fovea.left.scale)));
    const double prior_px = detail::median_disparity(mask, scene.disparity.dense, left_px, half_patch_px);
    const auto match = match_patch(fovea, view_px, prior_px, options.stereo_match);
    if (!match) continue;
    const auto probability_right = probability_at(right, match->right_view_px, model);
    if (!probability_right) continue;
    GraspConfiguration grasp =
        configure_grasp(on_object(fovea.left, patch_px, view_px), *match, mask, camera, *object.pose,
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
  object.intermediates.probabilities = probabilities;
  clock.stage_done("grasps");
  return object;
}

/// The hypotheses do not know of each other: any number of threads gives the same.
void detect_on_each_object(Detection& detection, const StereoCamera& camera, const Models& models,
                           const DetectorOptions& options) {
  const std::vector<ObjectHypothesis>& hypotheses = detection.segmentation.objects;
  std::vector<DetectedObject> objects(hypotheses.size());
  std::vector<Timings> timings_ms(hypotheses.size());
  std::vector<std::exception_ptr> failures(hypotheses.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < hypotheses.size(); i = next++) {
      try {
        objects[i] = detect_on_object(hypotheses[i], detection, camera, models, options, timings_ms[i]);
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

void check_models(const Models& models, const DetectorOptions& options) {
  if (models.empty()) throw InvalidInput("models: expected one or more, got none");
  const bool compares = models.size() > 1 || options.min_familiarity.value_or(0) > 0;
  std::set<std::string> names;
  for (const GraspModel* model : models) {
    model->check();
    if (compares && !model->familiarity) {
      throw InvalidInput("model '" + model->name + "' cannot tell what is familiar: " +
                         (models.size() > 1 ? "several models" : "min_familiarity") +
                         " expected one that was trained with familiarity");
    }
    if (!names.insert(model->name).second) {
      throw InvalidInput("models: expected different names, got two models named '" + model->name + "'");
    }
  }
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
  const double familiarity = min_familiarity.value_or(0);
  detail::require_option(familiarity >= 0 && familiarity <= 1, "min_familiarity must be 0 to 1");
  detail::require_option(max_grasps >= 1 && max_grasps <= 1000, "max_grasps must be 1 to 1000");
  detail::require_option(threads >= 1 && threads <= 256, "threads must be 1 to 256");
}

namespace {

Detection detect_with(const Models& models, const cv::Mat& left, const cv::Mat& right,
                      const StereoCamera& camera, const DetectorOptions& options, const cv::Mat& mask) {
  options.check();
  camera.check();
  check_models(models, options);
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
  detect_on_each_object(detection, camera, models, options);
  std::stable_sort(
      detection.objects.begin(), detection.objects.end(),
      [](const DetectedObject& a, const DetectedObject& b) { return best_grasp(a) > best_grasp(b); });
  return detection;
}

}  // namespace

Detection detect_grasps(const cv::Mat& left, const cv::Mat& right, const StereoCamera& camera,
                        const GraspModel& model, const DetectorOptions& options, const cv::Mat& mask) {
  return detect_with({&model}, left, right, camera, options, mask);
}

Detection detect_grasps(const cv::Mat& left, const cv::Mat& right, const StereoCamera& camera,
                        const std::vector<GraspModel>& models, const DetectorOptions& options,
                        const cv::Mat& mask) {
  Models asked;
  for (const GraspModel& model : models) asked.push_back(&model);
  return detect_with(asked, left, right, camera, options, mask);
}

}  // namespace graspctx
