// What concerns model files alone: models, info, export.
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "graspctx/io/model_file.hpp"

namespace graspctx::cli {

namespace {

using Json = nlohmann::ordered_json;

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

void list_models() {
  const std::vector<std::filesystem::path> files = shipped_models();
  if (files.empty()) {
    write_outputs({{standard_output, "no shipped model found\n"}});
    return;
  }
  Table table({0, 1, 3}, {"name", "classes", "support vectors", "file"});
  for (const std::filesystem::path& file : files) {
    const GraspModel model = load_model(file.string()).model;
    table.add({file.stem().string(), joined(model.classes), std::to_string(model.support_vectors.rows()),
               file.string()});
  }
  write_outputs({{standard_output, table.text()}});
}

/// Sections of names and values; the readable text is made from the same.
Json model_facts(const LoadedModel& loaded) {
  const GraspModel& model = loaded.model;
  const DescriptorOptions& descriptor = model.descriptor;
  return {{"schema", 1},
          {"model", {{"name", model.name}, {"sha256", loaded.sha256}}},
          {"classes", model.classes},
          {"svm",
           {{"c", model.svm_c},
            {"gamma", model.gamma},
            {"support_vectors", model.support_vectors.rows()},
            {"dimension", model.mean.size()},
            {"rho", model.rho},
            {"sigmoid_a", model.sigmoid_a},
            {"sigmoid_b", model.sigmoid_b}}},
          {"descriptor",
           {{"fovea_object_px", descriptor.fovea.object_px},
            {"fovea_margin_px", descriptor.fovea.margin_px},
            {"refine_mask", descriptor.fovea.refine_mask},
            {"canny_low", descriptor.contour.canny_low},
            {"canny_high", descriptor.contour.canny_high},
            {"samples", descriptor.contour.samples},
            {"mask_margin_px", descriptor.contour.mask_margin_px},
            {"angular_bins", descriptor.shape_context.angular_bins},
            {"radial_bins", descriptor.shape_context.radial_bins},
            {"inner_radius", descriptor.shape_context.inner_radius},
            {"outer_radius", descriptor.shape_context.outer_radius},
            {"relative_to_gradient", descriptor.shape_context.relative_to_gradient},
            {"outline_px", descriptor.shape_context.outline_px},
            {"patch_px", descriptor.patch.patch_px},
            {"windows_patches", descriptor.patch.windows_patches}}},
          {"provenance", model.provenance}};
}

std::string readable(const Json& facts) {
  std::string text;
  for (const auto& [section, content] : facts.items()) {
    if (section == "schema") continue;
    if (!content.is_object()) {
      text += section + ": " + joined(content.get<std::vector<std::string>>()) + "\n";
      continue;
    }
    text += section + "\n";
    for (const auto& [name, value] : content.items()) {
      text += "  " + name + ": " + (value.is_string() ? value.get<std::string>() : value.dump()) + "\n";
    }
  }
  return text;
}

struct InfoArguments {
  std::string model, json;
};

void info(const InfoArguments& arguments) {
  check_outputs({arguments.json});
  const Json facts = model_facts(load_model(arguments.model));
  if (arguments.json.empty()) {
    write_outputs({{standard_output, readable(facts)}});
  } else {
    write_outputs({{arguments.json, facts.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"}});
  }
}

struct ExportArguments {
  std::string model, libsvm;
};

void export_model(const ExportArguments& arguments) {
  const std::string range = arguments.libsvm + ".range";
  check_outputs({arguments.libsvm, range});
  const GraspModel model = load_model(arguments.model).model;
  write_outputs({{arguments.libsvm, model.to_libsvm()}, {range, model.libsvm_range()}});
}

}  // namespace

void add_models(CLI::App& program) {
  CLI::App& command = *program.add_subcommand("models", "List the shipped models.");
  command.footer("Example: graspctx_cli models");
  command.callback(list_models);
}

void add_info(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "info", "Print what a model is: classes, parameters, descriptor, and what it was trained on.");
  const auto arguments = std::make_shared<InfoArguments>();
  command.add_option("MODEL", arguments->model, "a shipped model or a .safetensors file")->required();
  command.add_option("--json", arguments->json, "write it as JSON; - prints it")->type_name("FILE|-");
  command.footer("Example: graspctx_cli info mug");
  command.callback([arguments] { info(*arguments); });
}

void add_export(CLI::App& program) {
  CLI::App& command = *program.add_subcommand("export", "Write a model in libsvm's text format.");
  const auto arguments = std::make_shared<ExportArguments>();
  command.add_option("MODEL", arguments->model, "a shipped model or a .safetensors file")->required();
  command
      .add_option("--libsvm", arguments->libsvm,
                  "the file to write; FILE.range beside it holds the scaling for svm-scale -r")
      ->required()
      ->type_name("FILE");
  command.footer("Example: graspctx_cli export mug --libsvm mug.model");
  command.callback([arguments] { export_model(*arguments); });
}

}  // namespace graspctx::cli
