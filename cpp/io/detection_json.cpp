#include "graspctx/io/detection_json.hpp"

#include "detail/json_values.hpp"
#include "graspctx/version.hpp"

namespace graspctx {

namespace {

using namespace detail;

Json pose_json(const ObjectPose& pose) {
  return {{"centroid_m", to_json(pose.centroid_m)},
          {"major_axis_m", to_json(pose.major_axis_m)},
          {"minor_axis_m", to_json(pose.minor_axis_m)},
          {"normal", to_json(pose.normal)},
          {"source", pose.source == ObjectPose::Source::stereo ? "stereo" : "segment_depth"}};
}

Json grasp_json(const GraspConfiguration& grasp) {
  return {{"rank", grasp.rank},
          {"probability", finite(grasp.probability)},
          {"probability_left", finite(grasp.probability_left)},
          {"probability_right", finite(grasp.probability_right)},
          {"left_px", to_json(grasp.left_px)},
          {"right_px", to_json(grasp.right_px)},
          {"position_m", to_json(grasp.position_m)},
          {"position_stddev_m", to_json(grasp.position_stddev_m)},
          {"rule", name_of(grasp.rule)},
          {"approach", to_json(grasp.approach)},
          {"closing", to_json(grasp.closing)},
          {"cam_from_hand", to_json(grasp.cam_from_hand)},
          {"opening_m", finite(grasp.opening_m)},
          {"feasible", grasp.feasible},
          {"infeasible_because", grasp.infeasible_because ? Json(*grasp.infeasible_because) : Json()}};
}

Json object_json(const DetectedObject& object) {
  Json grasps = Json::array();
  for (const GraspConfiguration& grasp : object.grasps) grasps.push_back(grasp_json(grasp));
  Json result{{"id", object.id},
              {"bounding_box_px", to_json(object.bounding_box_px)},
              {"centroid_px", to_json(object.centroid_px)},
              {"pose", object.pose ? pose_json(*object.pose) : Json()}};
  if (object.familiarity) {
    result["model"] = object.model_name;
    result["familiarity"] = finite(*object.familiarity);
    result["unfamiliar"] = object.unfamiliar;
  }
  result["grasps"] = std::move(grasps);
  return result;
}

}  // namespace

std::string detection_to_json(const Detection& detection, const std::string& model_name,
                              const std::string& model_sha256, int indent) {
  Json objects = Json::array();
  for (const DetectedObject& object : detection.objects) objects.push_back(object_json(object));
  const std::optional<TablePlane>& table = detection.segmentation.table;
  const Json document{{"schema", 1},
                      {"graspctx", version},
                      {"frame", "left_rectified_optical"},
                      {"image_size", {detection.image_size.width, detection.image_size.height}},
                      {"model", {{"name", model_name}, {"sha256", model_sha256}}},
                      {"table_plane", table ? to_json(*table) : Json()},
                      {"objects", std::move(objects)},
                      {"timings_ms", to_json(detection.timings_ms)}};
  return text_of(document, indent);
}

}  // namespace graspctx
