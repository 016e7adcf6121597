#include "detection_arguments.hpp"

#include <utility>

namespace graspctx::cli {

void add_detection_arguments(CLI::App& command, DetectionArguments& arguments) {
  add_pair_arguments(command, arguments.pair);
  command
      .add_option("--model", arguments.models,
                  "a shipped model (see `graspctx_cli models`) or a .safetensors file; of several, separated "
                  "by commas, the one that knows an object best answers")
      ->type_name("NAME|FILE[,...]")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->default_str("all shipped ones");
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

std::string DetectionRun::model_names() const {
  std::string names;
  for (const GraspModel& model : models) names += (names.empty() ? "" : ",") + model.name;
  return names;
}

std::string DetectionRun::model_hashes() const {
  std::string hashes;
  for (const std::string& hash : sha256) hashes += (hashes.empty() ? "" : ",") + hash;
  return hashes;
}

std::size_t DetectionRun::model_of(const DetectedObject& object) const {
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (models[i].name == object.model_name) return i;
  }
  return 0;  // a single one that cannot tell what is familiar
}

DetectionRun run_detection(const DetectionArguments& arguments, std::optional<int> max_grasps,
                           std::optional<double> min_familiarity) {
  DetectionRun run;
  run.pair = load_pair(arguments.pair);
  const LoadedPair& pair = run.pair;
  cv::Mat mask;
  if (!arguments.mask.empty()) mask = load_mask_for(arguments.mask, pair.left.size());
  for (const std::string& name_or_file : arguments.models) {
    LoadedModel loaded = load_model(name_or_file);
    run.models.push_back(std::move(loaded.model));
    run.sha256.push_back(std::move(loaded.sha256));
  }
  DetectorOptions options;
  options.segmentation = segmentation_options(arguments.segmentation, pair.left.size());
  options.threads = arguments.threads;
  options.min_familiarity = min_familiarity;
  if (max_grasps) options.max_grasps = *max_grasps;
  use_threads(arguments.threads);
  naming(arguments.pair.left, [&] {
    run.detection = detect_grasps(pair.left, pair.right, pair.camera, run.models, options, mask);
  });
  return run;
}

}  // namespace graspctx::cli
