#pragma once
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "graspctx/camera.hpp"
#include "graspctx/contour.hpp"
#include "graspctx/export.hpp"
#include "graspctx/grasp.hpp"
#include "graspctx/grasp_model.hpp"
#include "graspctx/grasp_points.hpp"
#include "graspctx/model_choice.hpp"
#include "graspctx/object_pose.hpp"
#include "graspctx/segmentation.hpp"
#include "graspctx/stereo.hpp"
#include "graspctx/stereo_match.hpp"

namespace graspctx {

struct GRASPCTX_EXPORT DetectorOptions {
  DisparityOptions disparity;
  SegmentationOptions segmentation;
  GraspPointOptions grasp_points;
  StereoMatchOptions stereo_match;
  HandOptions hand;
  double approach_threshold = 0.3;  // φ of Eq. 3, share of the minor semi-axis in the image
  double min_probability = 0.01;    // of both views together; what is less likely is no grasp
  int max_grasps = 10;              // of each object
  /// What an object is less familiar than, 0 to 1, is unfamiliar and has no grasps; 0 refuses none. Unset:
  /// default_min_familiarity if several models vote, 0 for one model.
  std::optional<double> min_familiarity;
  int threads = 1;  // the result is the same for any number
  void check() const;
};

/// What was looked at on the way, for pictures and for debugging.
struct ObjectIntermediates {
  FovealPair fovea;
  Contour contour;                // of the left foveal view
  PatchDescriptors patches;       // of the left foveal view
  Eigen::VectorXd probabilities;  // (M) of the patches; none if the object is unfamiliar
};

struct DetectedObject {
  int id = 0;  // its value in Detection::segmentation.instance_ids
  cv::Rect bounding_box_px;
  Eigen::Vector2d centroid_px{0, 0};
  std::optional<ObjectPose> pose;
  std::vector<GraspConfiguration> grasps;  // feasible first, then by probability (Eq. 2)
  std::string model_name;                  // the model that answers; empty if it cannot tell what is familiar
  std::optional<double> familiarity;       // of the object to that model, 0 to 1
  bool unfamiliar = false;                 // to all models: it has no grasps
  ObjectIntermediates intermediates;
};

struct Detection {
  cv::Size image_size;
  std::vector<DetectedObject> objects;  // the one with the best grasp first
  Segmentation segmentation;
  Disparity disparity;
  RectifiedPair pair;
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, double>> timings_ms;  // stage and time, in order
};

/// The whole method: from a stereo pair to ranked grasp configurations.
/// left, right: CV_8UC3 BGR or CV_8UC1, of equal size. mask (optional): CV_8UC1 instance ids of the left
/// rectified view, to be used instead of the segmentation. Throws InvalidInput for unusable input; finding
/// nothing is an answer.
GRASPCTX_EXPORT Detection detect_grasps(const cv::Mat& left, const cv::Mat& right, const StereoCamera& camera,
                                        const GraspModel& model, const DetectorOptions& options = {},
                                        const cv::Mat& mask = {});

/// The same with several models that vote on each object: choose_model says which one answers. Each needs a
/// familiarity and a name of its own; a view is described once for all that describe it alike.
GRASPCTX_EXPORT Detection detect_grasps(const cv::Mat& left, const cv::Mat& right, const StereoCamera& camera,
                                        const std::vector<GraspModel>& models,
                                        const DetectorOptions& options = {}, const cv::Mat& mask = {});

}  // namespace graspctx
