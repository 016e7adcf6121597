#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common.hpp"
#include "graspctx/detector.hpp"
#include "graspctx/io/model_file.hpp"

namespace graspctx::cli {

/// What every command takes that detects grasps: LEFT RIGHT --calibration FILE [FILE] [--rectified]
/// [--model NAME|FILE,...] [--mask FILE] [--threads N], and what the segmentation takes.
struct DetectionArguments {
  PairArguments pair;
  SegmentationArguments segmentation;
  std::vector<std::string> models{"book", "bowl", "box", "eraser", "mug", "pencil", "wineglass"};
  std::string mask;
  int threads = 1;
};
void add_detection_arguments(CLI::App& command, DetectionArguments& arguments);

struct DetectionRun {
  LoadedPair pair;
  std::vector<GraspModel> models;
  std::vector<std::string> sha256;  // of the models' files
  Detection detection;

  std::string model_names() const;   // separated by commas
  std::string model_hashes() const;  // likewise
  /// Index of the model that answers for an object.
  std::size_t model_of(const DetectedObject& object) const;
};
/// Throws InvalidInput naming the file.
DetectionRun run_detection(const DetectionArguments& arguments, std::optional<int> max_grasps = {},
                           std::optional<double> min_familiarity = {});

}  // namespace graspctx::cli
