#include "graspctx/io/dataset_files.hpp"

#include <algorithm>
#include <system_error>

#include "detail/coco_file.hpp"
#include "detail/dataset_reader.hpp"
#include "detail/json_file.hpp"

namespace graspctx {

namespace {

namespace fs = std::filesystem;
using detail::AnnotationKind;

const char* const expected_layouts =
    "expected scenes with dataset.json, img/ and grasp/ (Saxena), labelme's JSON files or a COCO file";

DatasetFormat format_of(AnnotationKind kind) {
  if (kind == AnnotationKind::labelme) return DatasetFormat::labelme;
  return kind == AnnotationKind::coco ? DatasetFormat::coco : DatasetFormat::detect;
}

bool has_scene(const fs::path& folder) {
  const std::vector<fs::path> entries = detail::sorted_entries(folder);
  return std::any_of(entries.begin(), entries.end(), [](const fs::path& entry) {
    std::error_code error;
    return entry.extension() != ".partial" && fs::exists(entry / "scene.json", error);
  });
}

/// What the JSON files of a folder are, by the first few in each place. What is no JSON is kept for the case
/// that nothing else is found.
std::vector<DatasetFormat> annotation_formats(const fs::path& folder, std::string& unreadable) {
  const int enough = 10;
  std::vector<DatasetFormat> formats;
  for (const fs::path& place : {folder, folder / "annotations"}) {
    if (!detail::is_folder(place)) continue;
    int looked_at = 0;
    for (const fs::path& file : detail::sorted_entries(place)) {
      if (file.extension() != ".json" || ++looked_at > enough) continue;
      try {
        const DatasetFormat format = format_of(detail::annotation_kind(file));
        const bool is_new = std::find(formats.begin(), formats.end(), format) == formats.end();
        if (format != DatasetFormat::detect && is_new) formats.push_back(format);
      } catch (const InvalidInput& error) {
        if (unreadable.empty()) unreadable = error.what();
      }
    }
  }
  return formats;
}

DatasetFormat resolved_format(const fs::path& path, const DatasetOptions& options) {
  const DatasetFormat format =
      options.format == DatasetFormat::detect ? detect_dataset_format(path) : options.format;
  const bool takes_labels = format == DatasetFormat::labelme || format == DatasetFormat::coco;
  if (!takes_labels && !(options.object_labels.empty() && options.grasp_labels.empty())) {
    detail::fail(path, std::string("is in the layout ") + name_of(format) +
                           ", expected no --object-label or --grasp-label: they are for labelme and COCO");
  }
  return format;
}

void require_exists(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) detail::fail(path, "no such folder, expected a data set");
}

void read_dataset(const fs::path& path, detail::Reading& reading) {
  const DatasetFormat format = reading.summary.format;
  if (format != DatasetFormat::coco && !detail::is_folder(path)) {
    detail::fail(path, "is a file, expected the folder of a data set");
  }
  if (format == DatasetFormat::saxena) return detail::read_saxena_dataset(path, reading);
  if (format == DatasetFormat::labelme) return detail::read_labelme_dataset(path, reading);
  if (format == DatasetFormat::coco) return detail::read_coco_dataset(path, reading);
  detail::read_graspctx_dataset(path, reading);
}

void add_to_summary(const LabelledView& view, DatasetSummary& summary) {
  DatasetSummary::ClassSummary& row = summary.classes[view.class_name];
  const int label_px = cv::countNonZero(view.label);
  ++row.objects;
  ++row.views;
  row.views_without_label += label_px == 0 ? 1 : 0;
  row.object_px += cv::countNonZero(view.mask);
  row.label_px += label_px;
}

}  // namespace

const char* name_of(DatasetFormat format) {
  switch (format) {
    case DatasetFormat::graspctx:
      return "graspctx";
    case DatasetFormat::saxena:
      return "saxena";
    case DatasetFormat::labelme:
      return "labelme";
    case DatasetFormat::coco:
      return "coco";
    case DatasetFormat::detect:
      break;
  }
  return "detect";
}

DatasetFormat detect_dataset_format(const fs::path& path) {
  require_exists(path);
  if (!detail::is_folder(path)) {
    if (path.extension() == ".json" && detail::annotation_kind(path) == AnnotationKind::coco) {
      return DatasetFormat::coco;
    }
    detail::fail(path, "is a file, expected the folder of a data set or a COCO file");
  }
  if (has_scene(path)) return DatasetFormat::graspctx;
  if (detail::is_folder(path / "img") && detail::is_folder(path / "grasp")) return DatasetFormat::saxena;
  std::string unreadable;
  const std::vector<DatasetFormat> formats = annotation_formats(path, unreadable);
  if (formats.size() == 1) return formats.front();
  if (formats.size() > 1) {
    detail::fail(path, "holds files of labelme and of COCO, expected one, or --format to choose");
  }
  std::error_code error;
  if (fs::exists(path / "dataset.json", error)) return DatasetFormat::graspctx;
  if (!unreadable.empty()) throw InvalidInput(unreadable);
  detail::fail(path, std::string("holds no data set, ") + expected_layouts);
}

std::vector<LabelledView> load_dataset(const fs::path& path, const DatasetOptions& options) {
  require_exists(path);
  std::vector<LabelledView> views;
  detail::Problems problems;
  DatasetSummary summary;
  summary.format = resolved_format(path, options);
  detail::Reading reading{options, problems, summary,
                          [&](LabelledView view) { views.push_back(std::move(view)); }};
  read_dataset(path, reading);
  if (views.empty() && !options.images.empty()) detail::fail(path, detail::no_image_wanted(options));
  if (views.empty()) detail::fail(path, "holds no object of the classes asked for");
  return views;
}

DatasetReport check_dataset(const fs::path& path, const DatasetOptions& options, std::size_t max_problems) {
  DatasetReport report;
  detail::Problems problems(max_problems);
  problems.collect([&] {
    require_exists(path);
    report.summary.format = resolved_format(path, options);
    if (report.summary.format == DatasetFormat::graspctx && detail::is_folder(path)) {
      detail::check_graspctx_dataset(path, problems, report.summary);
      return;
    }
    detail::Reading reading{options, problems, report.summary,
                            [&](const LabelledView& view) { add_to_summary(view, report.summary); }};
    read_dataset(path, reading);
  });
  report.problem_count = problems.count();
  report.problems = problems.take();
  return report;
}

}  // namespace graspctx
