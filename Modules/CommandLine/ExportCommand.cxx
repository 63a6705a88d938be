#include "Commands.h"
#include "Pipelines/ExportPipeline.h"

namespace kerf {
namespace {

struct ExportArguments {
  ExportRequest request;
  std::string space = "lps";
};

void Run(CommandContext& context, ExportArguments& a) {
  context.progress = MakeShellProgress(context.quiet);
  a.request.ras = a.space == "ras";
  const auto files = Export(a.request, *context.progress);
  context.progress->Report(1.0, "done");
  context.result = {{"files", files}, {"space", a.request.ras ? "RAS" : "LPS"}};
  for (const auto& file : files) context.Print(file);
  context.Print("Research use, not a medical device.");
}

}  // namespace

void AddExportCommand(CLI::App& app, CommandContext& context) {
  CLI::App* c = app.add_subcommand("export", "meshes and label maps for other programs");
  auto a = std::make_shared<ExportArguments>();
  c->add_option("CASE_OR_RESULTS", a->request.input, "case folder or results folder")->required();
  c->add_option("--format", a->request.format,
                "vtu: tetra mesh; vtp, stl, ply, obj, glb: surfaces; seg.nrrd: label map")
      ->required()
      ->check(CLI::IsMember({"vtu", "vtp", "stl", "ply", "obj", "glb", "seg.nrrd"}));
  c->add_option("--space", a->space,
                "patient frame of the files, written into them (glb: always metres, Y up)")
      ->check(CLI::IsMember({"lps", "ras"}))
      ->capture_default_str();
  c->add_option("--output", a->request.output, "folder for the files")->required();
  AddCommonOptions(c, &context);
  c->footer(
      "Of results, meshes are exported as they are in the last frame, cut; the separation "
      "surfaces are at rest.\n"
      "Examples:\n"
      "  kerf export case --format stl --output meshes\n"
      "  kerf export results --format seg.nrrd --space ras --output labels\n"
      "Exit status: 0 done, 2 wrong use, 3 bad input, 130 cancelled.");
  c->callback([a, &context] { Run(context, *a); });
}

}  // namespace kerf
