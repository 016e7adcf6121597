#include <memory>
#include <optional>

#include "commands.hpp"
#include "common.hpp"
#include "detection_arguments.hpp"
#include "graspctx/io/detection_json.hpp"
#include "graspctx/io/image_file.hpp"
#include "graspctx/io/picture.hpp"

namespace graspctx::cli {

namespace {

struct DetectArguments {
  DetectionArguments detection;
  std::string json, picture;
  std::optional<int> max_grasps;
  std::optional<double> min_familiarity;
};

/// The ranked grasps for a reader.
std::string detection_table(const Detection& detection) {
  if (detection.objects.empty()) return "no object found\n";
  std::string text;
  for (const DetectedObject& object : detection.objects) {
    text += (text.empty() ? "" : "\n") + std::string("object ") + std::to_string(object.id) + " at (" +
            fixed(object.centroid_px.x(), 0) + ", " + fixed(object.centroid_px.y(), 0) + ") px: ";
    if (object.familiarity) {
      text += object.unfamiliar ? "unfamiliar, most like what model " : "model ";
      text += object.model_name + (object.unfamiliar ? " was taught" : "") + ", familiarity " +
              fixed(*object.familiarity, 3) + ", ";
    }
    if (object.grasps.empty()) {
      text += "no grasp found\n";
      continue;
    }
    text += std::to_string(object.grasps.size()) + (object.grasps.size() == 1 ? " grasp\n" : " grasps\n");
    Table table({9, 10}, {"rank", "P", "u px", "v px", "x m", "y m", "z m", "+-z m", "opening m", "approach",
                          "feasible"});
    for (const GraspConfiguration& grasp : object.grasps) {
      table.add({std::to_string(grasp.rank), fixed(grasp.probability, 3), fixed(grasp.left_px.x(), 1),
                 fixed(grasp.left_px.y(), 1), fixed(grasp.position_m.x(), 3), fixed(grasp.position_m.y(), 3),
                 fixed(grasp.position_m.z(), 3), fixed(grasp.position_stddev_m.z(), 4),
                 fixed(grasp.opening_m, 3), name_of(grasp.rule),
                 grasp.feasible ? "yes" : "no: " + grasp.infeasible_because.value_or("unknown reason")});
    }
    text += table.text();
  }
  return text;
}

void detect(const DetectArguments& arguments) {
  check_outputs({arguments.json, arguments.picture});
  const DetectionRun run =
      run_detection(arguments.detection, arguments.max_grasps, arguments.min_familiarity);
  const Detection& detection = run.detection;

  std::vector<PendingFile> outputs;
  if (!arguments.json.empty()) {
    outputs.push_back({arguments.json, detection_to_json(detection, run.model_names(), run.model_hashes())});
  }
  if (!arguments.picture.empty()) {
    outputs.push_back(
        {arguments.picture, encode_image(arguments.picture, draw_detection(detection, run.pair.camera))});
  }
  if (arguments.json != standard_output) outputs.push_back({standard_output, detection_table(detection)});
  write_outputs(outputs);
  print_warnings(detection.warnings);
}

}  // namespace

void add_detect(CLI::App& program) {
  CLI::App& command = *program.add_subcommand("detect", "Find grasps on the objects of a stereo pair.");
  const auto arguments = std::make_shared<DetectArguments>();
  add_detection_arguments(command, arguments->detection);
  command.add_option("--max-grasps", arguments->max_grasps, "of each object")
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  command
      .add_option("--min-familiarity", arguments->min_familiarity,
                  "objects less familiar than that to every model have no grasps, 0 to 1; 0 refuses none "
                  "(default: 0.03 for several models, 0 for one)")
      ->check(CLI::Range(0.0, 1.0))
      ->type_name("SHARE");
  command.add_option("--json", arguments->json, "write the detection as JSON; - prints it")
      ->type_name("FILE|-");
  command.add_option("--picture", arguments->picture, "draw the grasps: .png, .jpg")
      ->check(has_extension({".png", ".jpg", ".jpeg"}))
      ->type_name("FILE");
  command.footer(
      "Prints a table of the ranked grasps unless --json - prints the JSON.\n"
      "Examples:\n"
      "  graspctx_cli detect left.png right.png --calibration calib.txt\n"
      "  graspctx_cli detect left.png right.png --calibration left.yaml right.yaml --model mug --json - "
      "--picture grasps.png\n"
      "  graspctx_cli detect left.png right.png --calibration calib.txt --model "
      "mug.safetensors,pan.safetensors\n"
      "  graspctx_cli detect left.png right.png --calibration calib.txt --fixate 320,240 --max-grasps 3");
  command.callback([arguments] { detect(*arguments); });
}

}  // namespace graspctx::cli
