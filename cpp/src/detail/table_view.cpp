#include "detail/table_view.hpp"

#include "detail/plain_table_objects.hpp"
#include "detail/strange_colours.hpp"
#include "detail/table_fit.hpp"
#include "detail/table_hypotheses.hpp"

namespace graspctx::detail {

cv::Mat TableView::ground() const {
  constexpr double on_table_px = 0.4;
  cv::Mat result;
  if (plane) result = relief.residual_px < on_table_px;
  if (plain) result = result.empty() ? plain->region : result | plain->region;
  return result;
}

TableView look_at_table(const RectifiedPair& pair, const Disparity& disparity, const StereoCamera& camera,
                        const SegmentationOptions& options) {
  TableView view;
  if (options.cues == CueLevel::disparity) return view;
  view.plain = find_plain_table(pair.left);
  view.plane = fit_table_plane(pair, disparity, camera, options, view.plain);
  if (options.cues != CueLevel::colour) view.plain.reset();  // what lies on it is told by colour
  if (view.plane) view.relief = relief_over_plane(pair, disparity, *view.plane);
  view.plain_on_plane = view.plain && view.plane && lies_on_plane(*view.plain, view.relief);
  if (view.plain && view.plane && !view.plain_on_plane) {
    // Two supports: the larger one it is.
    if (!outweighs_plane(*view.plain, view.relief)) {
      view.plain.reset();
    } else if (!options.table) {
      view.plane.reset();
    }
  }
  if (view.plane) view.frame = table_frame(view.relief, *view.plane, camera);
  if (view.plane) {
    view.raised = hypotheses_on_table(pair, view.relief, *view.plane, view.frame, camera, options);
  }
  if (options.cues != CueLevel::colour) return view;
  view.first_guess = cv::Mat::zeros(pair.left.size(), CV_8UC1);
  if (view.plane) {
    for (const cv::Mat& piece : raise_strange_colours(pair, *view.plane, view.frame, camera, view.relief)) {
      view.first_guess |= piece;
    }
  }
  if (view.plain) {
    const Relief* relief = view.plain_on_plane ? &view.relief : nullptr;
    for (const cv::Mat& figure :
         figures_on_plain_table(pair, disparity, *view.plain, relief, camera, options)) {
      view.first_guess |= figure;
    }
  }
  return view;
}

}  // namespace graspctx::detail
