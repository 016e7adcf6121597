#include <chrono>
#include <map>
#include <memory>
#include <utility>

#include "commands.hpp"
#include "common.hpp"
#include "graspctx/io/image_file.hpp"
#include "graspctx/io/picture.hpp"
#include "graspctx/io/segmentation_json.hpp"
#include "graspctx/segmentation.hpp"
#include "graspctx/stereo.hpp"

namespace graspctx::cli {

namespace {

struct SegmentArguments {
  PairArguments pair;
  SegmentationArguments segmentation;
  std::string output, json, picture;
  int threads = 1;
};

std::string remarks(const ObjectHypothesis& object) {
  if (!object.touches_border) return object.leaves_table ? "leaves the table" : "";
  return object.leaves_table ? "cut by the border, leaves the table" : "cut by the border";
}

std::string segmentation_table(const Segmentation& segmentation) {
  if (segmentation.objects.empty()) return "no object found\n";
  Table table({7}, {"id", "x px", "y px", "width px", "height px", "depth m", "size m", ""});
  for (const ObjectHypothesis& object : segmentation.objects) {
    const cv::Rect& box = object.bounding_box_px;
    const auto& size_m = object.size_m;
    table.add(
        {std::to_string(object.id), std::to_string(box.x), std::to_string(box.y), std::to_string(box.width),
         std::to_string(box.height), object.depth_m ? fixed(*object.depth_m, 3) : "-",
         size_m ? fixed(size_m->x(), 3) + " x " + fixed(size_m->y(), 3) + " x " + fixed(size_m->z(), 3) : "-",
         remarks(object)});
  }
  return table.text();
}

/// The levels that the picture sets side by side.
std::map<CueLevel, Segmentation> all_levels(const Segmentation& segmentation, const RectifiedPair& pair,
                                            const Disparity& disparity, const StereoCamera& camera,
                                            SegmentationOptions options) {
  std::map<CueLevel, Segmentation> levels{{options.cues, segmentation}};
  for (const CueLevel level : {CueLevel::disparity, CueLevel::plane, CueLevel::colour}) {
    options.cues = level;
    if (!levels.count(level)) levels[level] = segment_objects(pair, disparity, camera, options);
  }
  return levels;
}

void segment(const SegmentArguments& arguments) {
  check_outputs({arguments.output, arguments.json, arguments.picture});
  const LoadedPair pair = load_pair(arguments.pair);
  const SegmentationOptions options = segmentation_options(arguments.segmentation, pair.left.size());
  use_threads(arguments.threads);

  std::vector<std::pair<std::string, double>> timings_ms;
  const auto timed = [&](const std::string& stage, const auto& run) {
    const auto start = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double, std::milli> time_ms = std::chrono::steady_clock::now() - start;
    timings_ms.emplace_back(stage, time_ms.count());
  };
  RectifiedPair rectified;
  Disparity disparity;
  Segmentation segmentation;
  naming(arguments.pair.left, [&] {
    timed("rectify", [&] { rectified = rectify(pair.left, pair.right, pair.camera); });
    timed("disparity", [&] { disparity = compute_disparity(rectified); });
    timed("segmentation",
          [&] { segmentation = segment_objects(rectified, disparity, pair.camera, options); });
  });

  std::vector<PendingFile> outputs;
  if (!arguments.output.empty()) {
    outputs.push_back({arguments.output, encode_image(arguments.output, segmentation.instance_ids)});
  }
  if (!arguments.json.empty()) {
    outputs.push_back({arguments.json, segmentation_to_json(segmentation, options.cues, timings_ms)});
  }
  if (!arguments.picture.empty()) {
    const auto levels = all_levels(segmentation, rectified, disparity, pair.camera, options);
    outputs.push_back({arguments.picture,
                       encode_image(arguments.picture, draw_segmentation(rectified.left, disparity,
                                                                         pair.camera, levels, options))});
  }
  if (arguments.json != standard_output) {
    outputs.push_back({standard_output, segmentation_table(segmentation)});
  }
  write_outputs(outputs);
  print_warnings(segmentation.warnings);
}

}  // namespace

void add_segment(CLI::App& program) {
  CLI::App& command =
      *program.add_subcommand("segment", "Find the objects of a stereo pair: their mask, JSON or a picture.");
  const auto arguments = std::make_shared<SegmentArguments>();
  add_pair_arguments(command, arguments->pair);
  add_segmentation_arguments(command, arguments->segmentation);
  CLI::Option_group& outputs = *command.add_option_group("Outputs", "at least one");
  outputs.require_option(1, 0);
  outputs.add_option("--output", arguments->output, "the mask to write: 8-bit instance ids, 0 = background")
      ->check(has_extension({".png"}))
      ->type_name("MASK.png");
  outputs.add_option("--json", arguments->json, "write the objects and the table as JSON; - prints it")
      ->type_name("FILE|-");
  outputs
      .add_option("--picture", arguments->picture,
                  "draw the hypotheses, disparity, table, heights and the three cue levels: .png, .jpg")
      ->check(has_extension({".png", ".jpg", ".jpeg"}))
      ->type_name("FILE");
  add_threads_argument(command, arguments->threads);
  command.footer(
      "Prints the objects found, most salient first, unless --json - prints the JSON.\n"
      "Examples:\n"
      "  graspctx_cli segment left.png right.png --calibration calib.txt --output mask.png --cues plane\n"
      "  graspctx_cli segment left.png right.png --calibration calib.txt --picture scene.png --json -");
  command.callback([arguments] { segment(*arguments); });
}

}  // namespace graspctx::cli
