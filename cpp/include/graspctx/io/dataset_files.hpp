#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "graspctx/dataset.hpp"
#include "graspctx/export.hpp"

namespace graspctx {

/// Layouts of labelled images on the disk; docs/dataset-format.md describes each.
enum class DatasetFormat {
  detect,    // by what is in the folder or file
  graspctx,  // the project's own: scenes of stereo pairs, masks, labels
  saxena,    // img/NAME.png and grasp/graspPriorityWidth_NAME.png, one object before a plain background
  labelme,   // a folder of NAME.json, polygons by label name
  coco,      // one JSON file for many images, polygons or runs by category
};

/// "graspctx", "saxena", "labelme" or "coco".
GRASPCTX_EXPORT const char* name_of(DatasetFormat format);

enum class DatasetViews { left, both };

struct DatasetOptions {
  DatasetFormat format = DatasetFormat::detect;
  std::vector<std::string> classes;         // take these objects only; empty: all
  DatasetViews views = DatasetViews::both;  // of a stereo pair; the other layouts hold single images
  std::vector<std::string> images;          // take these only, by LabelledView::image_name; empty: all
  // labelme and COCO: what the annotations call objects and grasp regions. An object's class is its label.
  std::vector<std::string> object_labels, grasp_labels;
};

/// The layout of a data set, by what is in the folder (or of a JSON file). Throws InvalidInput, naming the
/// path, if it is none or fits more than one.
GRASPCTX_EXPORT DatasetFormat detect_dataset_format(const std::filesystem::path& path);

/// Read the labelled views of a data set, in an order that depends on names alone. Images are groups of their
/// own; the two views of a scene share one. Throws InvalidInput naming the file at the first problem, also if
/// no view is left.
GRASPCTX_EXPORT std::vector<LabelledView> load_dataset(const std::filesystem::path& path,
                                                       const DatasetOptions& options = {});

/// What a data set holds.
struct DatasetSummary {
  struct ClassSummary {
    int objects = 0, views = 0;   // an object is seen in one view or two
    int views_without_label = 0;  // its grasp region is hidden there
    std::int64_t object_px = 0, label_px = 0;
  };
  /// What the scenes say of one axis of difficulty.
  struct AxisSummary {
    std::map<std::string, int> scenes_of;  // by value, for words and true or false
    int numbers = 0;                       // scenes that give a number
    double lowest = 0, highest = 0;
  };
  DatasetFormat format = DatasetFormat::detect;
  int images = 0;
  int scenes = 0;                               // the project's layout only
  std::map<std::string, ClassSummary> classes;  // by name
  std::map<std::string, int> labels;            // labelme, COCO: outlines by label
  std::map<std::string, AxisSummary> axes;      // the project's layout, where given
};

struct DatasetReport {
  std::vector<std::string> problems;  // one line each: file, what is wrong, what was expected
  std::size_t problem_count = 0;      // also of those beyond max_problems
  DatasetSummary summary;             // of what could be read
};

/// Look at every file of a data set and name all that is wrong. labelme and COCO: without labels the outlines
/// are checked and counted by label; with labels also that each grasp region lies on an object.
GRASPCTX_EXPORT DatasetReport check_dataset(const std::filesystem::path& path,
                                            const DatasetOptions& options = {},
                                            std::size_t max_problems = 200);

}  // namespace graspctx
