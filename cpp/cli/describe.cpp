#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "graspctx/error.hpp"
#include "graspctx/io/image_file.hpp"
#include "graspctx/io/npy.hpp"
#include "graspctx/patch_descriptor.hpp"

namespace graspctx::cli {

namespace {

struct DescribeArguments {
  std::string image, mask, output;
  bool fovea = false;
};

void describe(const DescribeArguments& arguments) {
  check_outputs({arguments.output});
  const cv::Mat image = read_image(arguments.image);
  cv::Mat mask;
  if (!arguments.mask.empty()) mask = load_mask_for(arguments.mask, image.size());
  PatchDescriptors patches;
  naming(arguments.fovea ? arguments.mask : arguments.image, [&] {
    patches = arguments.fovea ? describe_view(foveal_view(image, mask))
                              : patch_descriptors(sample_contour(image, mask), image.size());
  });
  write_npy(arguments.output, patches.features);
}

}  // namespace

void add_describe(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "describe", "Shape-context descriptors of an image's 10x10 patches: an .npy file, (M, 120) float32.");
  const auto arguments = std::make_shared<DescribeArguments>();
  command.add_option("IMAGE", arguments->image, "PNG or JPEG")->required();
  CLI::Option* mask =
      command.add_option("--mask", arguments->mask, "8-bit PNG, > 0 = the object; otherwise the whole image")
          ->type_name("FILE");
  command
      .add_flag("--fovea", arguments->fovea,
                "re-sample the object to the foveal view's fixed size first, as detection does")
      ->needs(mask);
  command.add_option("--output", arguments->output, "the file to write")->required()->type_name("FILE.npy");
  command.footer("Example: graspctx_cli describe mug.png --mask mug_mask.png --output mug.npy");
  command.callback([arguments] { describe(*arguments); });
}

}  // namespace graspctx::cli
