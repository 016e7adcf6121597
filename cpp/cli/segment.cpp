#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "graspctx/io/image_file.hpp"
#include "graspctx/segmentation.hpp"
#include "graspctx/stereo.hpp"

namespace graspctx::cli {

namespace {

struct SegmentArguments {
  PairArguments pair;
  SegmentationArguments segmentation;
  std::string output;
  int threads = 1;
};

std::string segmentation_table(const Segmentation& segmentation) {
  if (segmentation.objects.empty()) return "no object found\n";
  Table table({}, {"id", "x px", "y px", "width px", "height px"});
  for (const ObjectHypothesis& object : segmentation.objects) {
    const cv::Rect& box = object.bounding_box_px;
    table.add({std::to_string(object.id), std::to_string(box.x), std::to_string(box.y),
               std::to_string(box.width), std::to_string(box.height)});
  }
  return table.text();
}

void segment(const SegmentArguments& arguments) {
  check_outputs({arguments.output});
  const LoadedPair pair = load_pair(arguments.pair);
  const SegmentationOptions options = segmentation_options(arguments.segmentation, pair.left.size());
  use_threads(arguments.threads);
  Segmentation segmentation;
  naming(arguments.pair.left, [&] {
    const RectifiedPair rectified = rectify(pair.left, pair.right, pair.camera);
    segmentation = segment_objects(rectified, compute_disparity(rectified), pair.camera, options);
  });
  write_outputs({{arguments.output, encode_image(arguments.output, segmentation.instance_ids)},
                 {standard_output, segmentation_table(segmentation)}});
  print_warnings(segmentation.warnings);
}

}  // namespace

void add_segment(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "segment", "Find the objects of a stereo pair: an 8-bit PNG of instance ids, 0 = background.");
  const auto arguments = std::make_shared<SegmentArguments>();
  add_pair_arguments(command, arguments->pair);
  add_segmentation_arguments(command, arguments->segmentation);
  command.add_option("--output", arguments->output, "the mask to write")
      ->required()
      ->check(has_extension({".png"}))
      ->type_name("MASK.png");
  add_threads_argument(command, arguments->threads);
  command.footer(
      "Prints the objects found, most salient first.\n"
      "Example: graspctx_cli segment left.png right.png --calibration calib.txt --output mask.png --cues "
      "plane");
  command.callback([arguments] { segment(*arguments); });
}

}  // namespace graspctx::cli
