#include "graspctx/io/segmentation_json.hpp"

#include "detail/json_values.hpp"
#include "graspctx/version.hpp"

namespace graspctx {

namespace {

using detail::finite;
using detail::Json;

Json or_null(const std::optional<double>& value) {
  return value ? Json(finite(*value)) : Json();
}

Json object_json(const ObjectHypothesis& object) {
  return {{"id", object.id},
          {"bounding_box_px", detail::to_json(object.bounding_box_px)},
          {"centroid_px", detail::to_json(object.centroid_px)},
          {"saliency", finite(object.saliency)},
          {"touches_border", object.touches_border},
          {"leaves_table", object.leaves_table},
          {"size_m", object.size_m ? detail::to_json(*object.size_m) : Json()},
          {"depth_m", or_null(object.depth_m)}};
}

}  // namespace

std::string segmentation_to_json(const Segmentation& segmentation, CueLevel cues,
                                 const std::vector<std::pair<std::string, double>>& timings_ms, int indent) {
  Json objects = Json::array();
  for (const ObjectHypothesis& object : segmentation.objects) objects.push_back(object_json(object));
  const cv::Size size = segmentation.instance_ids.size();
  return detail::text_of({{"schema", 1},
                          {"graspctx", version},
                          {"frame", "left_rectified_optical"},
                          {"image_size", {size.width, size.height}},
                          {"cues", name_of(cues)},
                          {"table_plane", segmentation.table ? detail::to_json(*segmentation.table) : Json()},
                          {"objects", std::move(objects)},
                          {"vertical_offset_px", or_null(segmentation.vertical_offset_px)},
                          {"warnings", segmentation.warnings},
                          {"timings_ms", detail::to_json(timings_ms)}},
                         indent);
}

}  // namespace graspctx
