#include "graspctx/io/detection_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "graspctx/version.hpp"

namespace graspctx {

namespace {

using Json = nlohmann::ordered_json;

/// JSON has no NaN. A detection never holds one: if it does, that is a fault of the program, not of the
/// input.
double finite(double value) {
  if (!std::isfinite(value)) throw std::logic_error("the detection holds a number that is not finite");
  return value;
}

template <typename Derived>
Json to_json(const Eigen::MatrixBase<Derived>& matrix) {
  Json result = Json::array();
  if constexpr (Derived::ColsAtCompileTime == 1) {
    for (Eigen::Index i = 0; i < matrix.size(); ++i) result.push_back(finite(matrix(i)));
  } else {
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
      result.push_back(to_json(matrix.row(i).transpose().eval()));
  }
  return result;
}

Json to_json(const TablePlane& table) {
  return {{"normal", to_json(table.normal)}, {"offset_m", finite(table.offset_m)}};
}

Json to_json(const ObjectPose& pose) {
  return {{"centroid_m", to_json(pose.centroid_m)},
          {"major_axis_m", to_json(pose.major_axis_m)},
          {"minor_axis_m", to_json(pose.minor_axis_m)},
          {"normal", to_json(pose.normal)},
          {"source", pose.source == ObjectPose::Source::stereo ? "stereo" : "segment_depth"}};
}

Json to_json(const GraspConfiguration& grasp) {
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

Json to_json(const DetectedObject& object) {
  const cv::Rect& box = object.bounding_box_px;
  Json grasps = Json::array();
  for (const GraspConfiguration& grasp : object.grasps) grasps.push_back(to_json(grasp));
  return {{"id", object.id},
          {"bounding_box_px", {box.x, box.y, box.width, box.height}},
          {"centroid_px", to_json(object.centroid_px)},
          {"pose", object.pose ? to_json(*object.pose) : Json()},
          {"grasps", std::move(grasps)}};
}

}  // namespace

std::string detection_to_json(const Detection& detection, const std::string& model_name,
                              const std::string& model_sha256, int indent) {
  Json objects = Json::array();
  for (const DetectedObject& object : detection.objects) objects.push_back(to_json(object));
  Json timings = Json::object();
  for (const auto& [stage, time_ms] : detection.timings_ms) timings[stage] = finite(time_ms);
  const std::optional<TablePlane>& table = detection.segmentation.table;
  const Json document{{"schema", 1},
                      {"graspctx", version},
                      {"frame", "left_rectified_optical"},
                      {"image_size", {detection.image_size.width, detection.image_size.height}},
                      {"model", {{"name", model_name}, {"sha256", model_sha256}}},
                      {"table_plane", table ? to_json(*table) : Json()},
                      {"objects", std::move(objects)},
                      {"timings_ms", std::move(timings)}};
  return document.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace graspctx
