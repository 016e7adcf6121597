#include "graspctx/io/explanation_json.hpp"

#include "detail/bin_effects.hpp"
#include "detail/json_values.hpp"
#include "graspctx/version.hpp"

namespace graspctx {

namespace {

using namespace detail;

Json points_json(const GraspExplanation& explanation) {
  Json view_px = Json::array(), left_px = Json::array(), effects = Json::array();
  for (std::size_t i = 0; i < explanation.contour.points.size(); ++i) {
    const Eigen::Vector2d point(explanation.contour.points[i].x, explanation.contour.points[i].y);
    view_px.push_back(to_json(point));
    left_px.push_back(to_json(explanation.view.image_from_view(point)));
    effects.push_back(finite(explanation.patch.point_effects[i]));
  }
  return {{"left_px", std::move(left_px)}, {"view_px", std::move(view_px)}, {"effects", std::move(effects)}};
}

Json windows_json(const GraspExplanation& explanation) {
  Json windows = Json::array();
  for (int window = 0; window < 3; ++window) {
    windows.push_back(
        {{"side_px", window_px(explanation, window)},
         {"effect_sum", finite(window_effect(explanation, window))},
         {"effects", to_json(bin_grid(explanation, window))},
         {"outline_effects",
          has_outline(explanation) ? to_json(bin_grid(explanation, window, /*outline=*/true)) : Json()}});
  }
  return windows;
}

Json images_json(const std::vector<NearImage>& images) {
  Json list = Json::array();
  for (const NearImage& image : images) {
    list.push_back({{"name", image.name},
                    {"similarity", finite(image.similarity)},
                    {"support_vectors", image.support_vectors},
                    {"contribution", finite(image.contribution)}});
  }
  return list;
}

}  // namespace

std::string explanation_to_json(const GraspExplanation& explanation, const std::string& model_name,
                                const std::string& model_sha256, int indent) {
  const GraspConfiguration& grasp = explanation.grasp;
  const PatchExplanation& patch = explanation.patch;
  const FovealView& view = explanation.view;
  const bool knows_images = !patch.graspable.empty() || !patch.not_graspable.empty();
  return text_of({{"schema", 1},
                  {"graspctx", version},
                  {"model", {{"name", model_name}, {"sha256", model_sha256}}},
                  {"object", explanation.object_id},
                  {"rank", grasp.rank},
                  {"probability", finite(grasp.probability)},
                  {"probability_left", finite(grasp.probability_left)},
                  {"probability_right", finite(grasp.probability_right)},
                  {"left_px", to_json(grasp.left_px)},
                  {"decision_value", finite(patch.decision_value)},
                  {"view",
                   {{"size", {view.image.cols, view.image.rows}},
                    {"scale", finite(view.scale)},
                    {"origin_px", to_json(view.origin_px)}}},
                  {"patch",
                   {{"view_px", {finite(patch.centre_px.x), finite(patch.centre_px.y)}},
                    {"side_px", explanation.descriptor.patch.patch_px}}},
                  {"points", points_json(explanation)},
                  {"windows", windows_json(explanation)},
                  {"ring_radii_px", patch.ring_radii_px},
                  {"other_effect", patch.other_effect ? Json(finite(*patch.other_effect)) : Json()},
                  {"nearest_images", knows_images ? Json{{"graspable", images_json(patch.graspable)},
                                                         {"not_graspable", images_json(patch.not_graspable)}}
                                                  : Json()}},
                 indent);
}

}  // namespace graspctx
