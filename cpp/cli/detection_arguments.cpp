#include "detection_arguments.hpp"

namespace graspctx::cli {

void add_detection_arguments(CLI::App& command, DetectionArguments& arguments) {
  add_pair_arguments(command, arguments.pair);
  command
      .add_option("--model", arguments.model,
                  "a shipped model (see `graspctx_cli models`) or a .safetensors file")
      ->type_name("NAME|FILE")
      ->capture_default_str();
  add_segmentation_arguments(command, arguments.segmentation);
  command
      .add_option("--mask", arguments.mask,
                  "8-bit PNG, instance ids of the left rectified view: instead of the segmentation")
      ->type_name("FILE")
      ->excludes("--cues")
      ->excludes("--fixate")
      ->excludes("--roi");
  add_threads_argument(command, arguments.threads);
}

DetectionRun run_detection(const DetectionArguments& arguments, std::optional<int> max_grasps) {
  DetectionRun run;
  run.pair = load_pair(arguments.pair);
  const LoadedPair& pair = run.pair;
  cv::Mat mask;
  if (!arguments.mask.empty()) mask = load_mask_for(arguments.mask, pair.left.size());
  run.model = load_model(arguments.model);
  DetectorOptions options;
  options.segmentation = segmentation_options(arguments.segmentation, pair.left.size());
  options.threads = arguments.threads;
  if (max_grasps) options.max_grasps = *max_grasps;
  use_threads(arguments.threads);
  naming(arguments.pair.left, [&] {
    run.detection = detect_grasps(pair.left, pair.right, pair.camera, run.model.model, options, mask);
  });
  return run;
}

}  // namespace graspctx::cli
