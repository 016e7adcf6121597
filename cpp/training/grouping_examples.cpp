// What the trees of the grouping are trained on: see tools/train_grouping.
#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <iostream>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "detail/grouping.hpp"
#include "detail/grouping_trees.hpp"
#include "detail/scene_cues.hpp"
#include "detail/table_view.hpp"
#include "detail/whole_objects.hpp"
#include "graspctx/io/atomic_file.hpp"
#include "graspctx/io/calibration_file.hpp"
#include "graspctx/io/image_file.hpp"
#include "graspctx/segmentation.hpp"

namespace {

using namespace graspctx;
using detail::Features;

/// Rows of label, weight, features.
struct Examples {
  std::vector<float> rows;
  std::size_t columns = 0;
  void add(double label, double weight, const Features& features) {
    columns = features.size() + 2;
    rows.push_back(static_cast<float>(label));
    rows.push_back(static_cast<float>(weight));
    rows.insert(rows.end(), features.begin(), features.end());
  }
};

using Votes = std::array<int, 256>;  // pixels by the true object's id, 0 = none

int winner(const Votes& votes) {
  return static_cast<int>(std::max_element(votes.begin(), votes.end()) - votes.begin());
}

void add_scene(const std::string& folder, const std::string& what, Examples& examples) {
  const StereoCamera camera = load_calibration({folder + "/calib.txt"});
  const RectifiedPair pair =
      rectify(read_image(folder + "/left.png"), read_image(folder + "/right.png"), camera);
  const Disparity disparity = compute_disparity(pair);
  const SegmentationOptions options;
  const detail::TableView view = detail::look_at_table(pair, disparity, camera, options);
  const detail::SceneCues cues = detail::scene_cues(pair, disparity, camera, view);
  const detail::Superpixels superpixels = detail::find_superpixels(cues.image);
  detail::RegionGraph graph = detail::region_graph(cues, superpixels);

  cv::Mat truth;
  cv::resize(read_mask(folder + "/left_mask.png"), truth, cues.image.size(), 0, 0, cv::INTER_NEAREST);
  std::vector<Votes> votes(graph.regions.size(), Votes{});
  Votes sizes{};
  for (int v = 0; v < truth.rows; ++v) {
    for (int u = 0; u < truth.cols; ++u) {
      ++votes[std::size_t(superpixels.labels.at<int>(v, u))][truth.at<uchar>(v, u)];
      ++sizes[truth.at<uchar>(v, u)];
    }
  }
  if (what == "foreground") {
    for (int region = 0; region < superpixels.count; ++region) {
      const double area = graph.regions[std::size_t(region)].sums.area;
      const double on_objects = 1 - votes[std::size_t(region)][0] / area;
      examples.add(on_objects, area, detail::foreground_features(graph, region, cues));
    }
    return;
  }
  detail::judge_foreground(graph, cues);
  detail::Grouping grouping(graph);
  if (what == "union") {
    // Only right unions happen, so that what is asked next is worth an answer, and all
    // regions of a group are of one object.
    grouping.run(
        [&](int a, int b, const Features& features) {
          const int object = winner(votes[std::size_t(a)]);
          const bool same = object > 0 && object == winner(votes[std::size_t(b)]);
          examples.add(same, 1, features);
          if (!same) return 0.0;
          if (detail::union_trees.trees > 0) return 0.01 + detail::learnt_union_probability(a, b, features);
          return 1 / (1 + 0.05 * double(features[5] + features[8] + 2 * features[9]));
        },
        1e-6);
    return;
  }
  grouping.run(detail::learnt_union_probability, detail::least_union_probability);
  std::vector<Features> in_context;
  if (what == "whole") {
    in_context = detail::features_in_context(grouping, detail::learnt_probabilities_by_itself(grouping));
  }
  for (int group = 0; group < static_cast<int>(grouping.groups().size()); ++group) {
    Votes sum{};
    double area = 0;
    for (const int region : grouping.regions_of(group)) {
      for (std::size_t id = 0; id < sum.size(); ++id) {
        sum[id] += votes[std::size_t(region)][id];
        area += votes[std::size_t(region)][id];
      }
    }
    double best = 0;
    for (std::size_t id = 1; id < sum.size(); ++id) {
      best = std::max(best, sum[id] / std::max(1.0, area + sizes[id] - sum[id]));
    }
    examples.add(best, 1, what == "whole" ? in_context[std::size_t(group)] : grouping.features_of(group));
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (argc < 4 || (what != "foreground" && what != "union" && what != "object" && what != "whole")) {
    std::cerr << "usage: graspctx_grouping_examples foreground|union|object|whole OUT.f32 SCENE…\n";
    return 2;
  }
  try {
    Examples examples;
    for (int i = 3; i < argc; ++i) add_scene(argv[i], what, examples);
    write_file_atomically(argv[2], examples.rows.data(), examples.rows.size() * sizeof(float));
    std::cout << examples.columns << "\n";
  } catch (const std::exception& error) {
    std::cerr << "graspctx_grouping_examples: " << error.what() << "\n";
    return 1;
  }
}
