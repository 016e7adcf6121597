// The layout of Saxena et al. (2007): img/NAME.png and grasp/graspPriorityWidth_NAME.png.
#include <opencv2/imgproc.hpp>

#include "detail/dataset_reader.hpp"
#include "graspctx/io/image_file.hpp"
#include "graspctx/segmentation.hpp"

namespace graspctx::detail {

namespace {

namespace fs = std::filesystem;

constexpr const char* class_name = "object";  // the layout knows no classes

/// Any pixel that is not black is graspable.
cv::Mat coloured_pixels(const cv::Mat& image) {
  if (image.channels() == 1) return image > 0;
  cv::Mat channels[3];
  cv::split(image, channels);
  return (channels[0] | channels[1] | channels[2]) > 0;
}

void read_image_with_label(const fs::path& file, const fs::path& label_file, int group, Reading& reading) {
  LabelledView view{file.string(), class_name, group, read_image(file), {}, {}, file.filename().string()};
  const cv::Mat label_image = read_image(label_file);
  require_size(label_file, label_image, view.image.size(), "its image");
  const cv::Mat label = coloured_pixels(label_image);
  view.mask = plain_background_mask(view.image);
  if (cv::countNonZero(view.mask) == 0) {
    fail(file, "shows no object, expected one that differs from a plain background");
  }
  view.label = label & view.mask;
  // A label on the background: the two files do not belong together, or the object was not found.
  if (2 * cv::countNonZero(view.label) < cv::countNonZero(label)) {
    fail(label_file, "less than half of the label lies on the object that stands out from the background");
  }
  reading.emit(std::move(view));
}

}  // namespace

void read_saxena_dataset(const fs::path& folder, Reading& reading) {
  if (!is_wanted(class_name, reading.options)) {
    fail(folder, std::string("is in Saxena's layout and knows no classes but '") + class_name + "'");
  }
  if (!is_folder(folder / "img")) fail(folder / "img", "no such folder, expected Saxena's layout");
  for (const fs::path& file : sorted_entries(folder / "img")) {
    if (file.extension() != ".png") continue;
    const fs::path label_file = folder / "grasp" / ("graspPriorityWidth_" + file.stem().string() + ".png");
    const int group = reading.summary.images++;
    if (!is_image_wanted(file.filename().string(), reading.options)) continue;
    reading.problems.collect([&] { read_image_with_label(file, label_file, group, reading); });
  }
  if (reading.summary.images == 0) fail(folder / "img", "holds no PNG image");
}

}  // namespace graspctx::detail
