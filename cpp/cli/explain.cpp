#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "common.hpp"
#include "detection_arguments.hpp"
#include "graspctx/error.hpp"
#include "graspctx/explanation.hpp"
#include "graspctx/io/dataset_files.hpp"
#include "graspctx/io/explanation_json.hpp"
#include "graspctx/io/image_file.hpp"
#include "graspctx/io/picture.hpp"

namespace graspctx::cli {

namespace {

struct ExplainArguments {
  DetectionArguments detection;
  std::optional<int> object;
  int rank = 1;
  std::string json, picture, training_data;
};

std::string signed_number(double value, int decimals) {
  return (value >= 0 ? "+" : "") + fixed(value, decimals);
}

const DetectedObject& chosen_object(const Detection& detection, const ExplainArguments& arguments) {
  const std::string& left = arguments.detection.pair.left;
  if (detection.objects.empty()) throw InvalidInput(left + ": no object found, nothing to explain");
  if (!arguments.object) return detection.objects.front();
  std::string ids;
  for (const DetectedObject& object : detection.objects) {
    if (object.id == *arguments.object) return object;
    ids += (ids.empty() ? "" : ", ") + std::to_string(object.id);
  }
  throw InvalidInput(left + ": no object " + std::to_string(*arguments.object) +
                     ", expected one of those found: " + ids);
}

// ---- The text ---------------------------------------------------------------------------------------------

/// Contour samples within a square around the patch, but not within a smaller one.
void add_points(Table& table, const std::string& where, const GraspExplanation& explanation, double beyond_px,
                double within_px) {
  int count = 0, in_favour = 0;
  double sum = 0;
  for (std::size_t i = 0; i < explanation.contour.points.size(); ++i) {
    const cv::Point2f offset_px = explanation.contour.points[i] - explanation.patch.centre_px;
    const double distance_px = std::max(std::abs(offset_px.x), std::abs(offset_px.y));
    if (distance_px <= beyond_px || distance_px > within_px) continue;
    const double effect = explanation.patch.point_effects[i];
    ++count;
    in_favour += effect > 0 ? 1 : 0;
    sum += effect;
  }
  table.add({where, std::to_string(count), std::to_string(in_favour), signed_number(sum, 3)});
}

std::string points_text(const GraspExplanation& explanation) {
  const PatchOptions& patch = explanation.descriptor.patch;
  const int widest = *std::max_element(patch.windows_patches.begin(), patch.windows_patches.end());
  const double patch_px = 0.5 * patch.patch_px, window_px = widest * patch_px;
  Table table({0}, {"contour points left out, one by one", "points", "for", "sum of effects on f"});
  add_points(table, "in the patch", explanation, -1, patch_px);
  add_points(table, "around it, in its windows", explanation, patch_px, window_px);
  add_points(table, "the rest of the shape", explanation, window_px, 1e9);
  return table.text();
}

/// The bin that speaks loudest, for or against.
struct LoudestBin {
  int window = 0, angle = 0, ring = 0;
  bool outline = false;
  double effect = 0;
};

LoudestBin loudest_bin(const GraspExplanation& explanation, int sign) {
  const ShapeContextOptions& shape = explanation.descriptor.shape_context;
  Eigen::Index column = 0;
  (sign * explanation.patch.bin_effects).maxCoeff(&column);
  const int bins = shape.angular_bins * shape.radial_bins;
  const int in_window = static_cast<int>(column) % shape.bins(), bin = in_window % bins;
  return {static_cast<int>(column) / shape.bins(), bin / shape.radial_bins, bin % shape.radial_bins,
          in_window >= bins, explanation.patch.bin_effects[column]};
}

void add_bin(Table& table, const std::string& what, const GraspExplanation& explanation, int sign) {
  const LoudestBin loudest = loudest_bin(explanation, sign);
  if (sign * loudest.effect <= 0) return;
  const DescriptorOptions& descriptor = explanation.descriptor;
  const double sector_degrees = 360.0 / descriptor.shape_context.angular_bins;
  const std::vector<double>& radii = explanation.patch.ring_radii_px;
  const auto ring = static_cast<std::size_t>(loudest.ring);
  const int side_px =
      descriptor.patch.patch_px * descriptor.patch.windows_patches[static_cast<std::size_t>(loudest.window)];
  table.add(
      {what, std::to_string(side_px) + " px" + (loudest.outline ? ", outline" : ""),
       fixed(loudest.angle * sector_degrees, 0) + " to " + fixed((loudest.angle + 1) * sector_degrees, 0),
       fixed(ring == 0 ? 0 : radii[ring - 1], 0) + " to " + fixed(radii[ring], 0),
       signed_number(loudest.effect, 3)});
}

std::string bins_text(const GraspExplanation& explanation) {
  Table table({0, 1},
              {"bin put to its mean", "window", "degrees from right, clockwise", "px away", "effect on f"});
  add_bin(table, "strongest for", explanation, 1);
  add_bin(table, "strongest against", explanation, -1);
  return table.text();
}

void add_images(Table& table, const std::string& label, const std::vector<NearImage>& images) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    table.add({i == 0 ? label : "", images[i].name, fixed(images[i].similarity, 3),
               std::to_string(images[i].support_vectors), signed_number(images[i].contribution, 3)});
  }
}

std::string images_text(const PatchExplanation& patch) {
  if (patch.graspable.empty() && patch.not_graspable.empty()) {
    return "The model does not say which images it was trained on: train it anew to know the nearest.\n";
  }
  Table table({0, 1}, {"nearest training images", "image", "similarity", "support vectors", "part of f"});
  add_images(table, "graspable there", patch.graspable);
  add_images(table, "not graspable there", patch.not_graspable);
  return table.text();
}

std::string explanation_text(const GraspExplanation& explanation) {
  const GraspConfiguration& grasp = explanation.grasp;
  const PatchExplanation& patch = explanation.patch;
  std::string text = "object " + std::to_string(explanation.object_id) + ", grasp " +
                     std::to_string(grasp.rank) + " at (" + fixed(grasp.left_px.x(), 1) + ", " +
                     fixed(grasp.left_px.y(), 1) + ") px: P " + fixed(grasp.probability, 3) + " = left " +
                     fixed(grasp.probability_left, 3) + " x right " + fixed(grasp.probability_right, 3) +
                     ", f " + signed_number(patch.decision_value, 3) + " in the left view\n";
  if (patch.other_effect)
    text += "appearance at its mean: " + signed_number(*patch.other_effect, 3) + " of f\n";
  return text + "\n" + points_text(explanation) + "\n" + bins_text(explanation) + "\n" + images_text(patch);
}

// -----------------------------------------------------------------------------------------------------------

std::vector<std::string> names_of_images(const PatchExplanation& patch) {
  std::vector<std::string> names;
  for (const std::vector<NearImage>* images : {&patch.graspable, &patch.not_graspable}) {
    for (const NearImage& image : *images) names.push_back(image.name);
  }
  return names;
}

PatchExplanation with_training_data(const PatchExplanation& patch, const GraspModel& model,
                                    const ExplainArguments& arguments) {
  DatasetOptions options;
  options.images = names_of_images(patch);
  if (options.images.empty()) {
    throw InvalidInput("--training-data: the model '" + model.name +
                       "' does not say which images it was trained on, expected one trained anew");
  }
  PatchExplanation found;
  naming(arguments.training_data, [&] {
    found = find_training_patches(patch, model, load_dataset(arguments.training_data, options));
  });
  return found;
}

void explain(const ExplainArguments& arguments) {
  check_outputs({arguments.json, arguments.picture});
  const DetectionRun run = run_detection(arguments.detection);
  std::size_t answering = 0;
  GraspExplanation explanation;
  naming(arguments.detection.pair.left, [&] {
    const DetectedObject& object = chosen_object(run.detection, arguments);
    answering = run.model_of(object);
    explanation = explain_grasp(object, run.models[answering], arguments.rank);
  });
  const GraspModel& model = run.models[answering];
  if (!arguments.training_data.empty()) {
    explanation.patch = with_training_data(explanation.patch, model, arguments);
  }
  std::vector<PendingFile> outputs;
  if (!arguments.json.empty()) {
    outputs.push_back({arguments.json, explanation_to_json(explanation, model.name, run.sha256[answering])});
  }
  if (!arguments.picture.empty()) {
    outputs.push_back({arguments.picture, encode_image(arguments.picture, draw_explanation(explanation))});
  }
  if (arguments.json != standard_output) outputs.push_back({standard_output, explanation_text(explanation)});
  write_outputs(outputs);
  print_warnings(run.detection.warnings);
}

}  // namespace

void add_explain(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "explain", "Say what a grasp rests on: contour points, bins of the shape context, training images.");
  const auto arguments = std::make_shared<ExplainArguments>();
  add_detection_arguments(command, arguments->detection);
  command
      .add_option("--object", arguments->object, "the object's id; by default the one with the best grasp")
      ->check(CLI::Range(1, 255))
      ->type_name("ID");
  command.add_option("--rank", arguments->rank, "which of its grasps")
      ->check(CLI::Range(1, 1000))
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--json", arguments->json, "write the explanation as JSON; - prints it")
      ->type_name("FILE|-");
  CLI::Option* picture =
      command.add_option("--picture", arguments->picture, "draw the explanation: .png, .jpg")
          ->check(has_extension({".png", ".jpg", ".jpeg"}))
          ->type_name("FILE");
  command
      .add_option("--training-data", arguments->training_data,
                  "the data set that the model was trained on: the nearest images are drawn")
      ->needs(picture)
      ->type_name("FOLDER");
  command.footer(
      "Prints a summary unless --json - prints the JSON (docs/explain.md).\n"
      "Example: graspctx_cli explain left.png right.png --calibration calib.txt --model mug --rank 2 "
      "--picture why.png");
  command.callback([arguments] { explain(*arguments); });
}

}  // namespace graspctx::cli
