#include <filesystem>

#include "Commands.h"
#include "Pipelines/ValidatePipeline.h"
#include "Pipelines/ValidationTables.h"

namespace kerf {
namespace {

struct ValidateArguments {
  ValidateRequest request;
  std::string method = "kerf", cutting = "both", input = "video", render = "off", grips = "on",
              outline = "on";
  int tetrahedra = 0;
};

std::vector<ValidationVariant> VariantsOf(const ValidateArguments& a) {
  std::vector<ValidationVariant> variants;
  for (const Method method : {Method::Kerf, Method::Reference})
    for (const bool tracks : {false, true})
      for (const bool cutting : {true, false}) {
        if (a.method != "both" && (a.method == "kerf") != (method == Method::Kerf)) continue;
        if (a.input != "both" && (a.input == "tracks") != tracks) continue;
        if (a.cutting != "both" && (a.cutting == "on") != cutting) continue;
        variants.push_back({method, cutting, tracks});
      }
  return variants;
}

void Run(const CLI::App& command, CommandContext& context, ValidateArguments& a) {
  context.progress = MakeShellProgress(context.quiet);
  a.request.variants = VariantsOf(a);
  if (a.render == "on") a.request.drawing = ReplayRequest::Drawing::Video;
  a.request.grips = a.grips == "on";
  a.request.outline = a.outline == "on";
  a.request.threads = context.threads;
  if (command.count("--tetrahedra") > 0) a.request.tetrahedra = a.tetrahedra;
  const auto runs = Validate(a.request, *context.progress);
  context.progress->Report(1.0, "done");
  const auto path = [&](const char* name) {
    return (std::filesystem::path(a.request.output) / name).string();
  };
  int failed = 0;
  for (const auto& run : runs) failed += !run.error.empty();
  context.result = {{"runs", runs.size()},
                    {"failed", failed},
                    {"report", path("validation.html")},
                    {"figures", path("validation.json")}};
  for (const auto& table : DiceTables(runs)) context.Print(Markdown(table));
  for (const auto& table : DistanceTables(runs)) context.Print(Markdown(table));
  context.Print(Markdown(CutTable(runs)));
  context.Print("Report: " + path("validation.html") + "\nResearch use, not a medical device.");
  if (failed > 0) context.exit_status = 3;
}

}  // namespace

void AddValidateCommand(CLI::App& app, CommandContext& context) {
  CLI::App* c =
      app.add_subcommand("validate", "replay and evaluate many studies, one report over all");
  auto a = std::make_shared<ValidateArguments>();
  c->add_option("STUDIES", a->request.studies, "study folders with truth/")->required();
  c->add_option("--output", a->request.output,
                "folder for validation.html and the results of every run")
      ->required();
  c->add_option("--method", a->method, "registration method")
      ->check(CLI::IsMember({"kerf", "reference", "both"}))
      ->capture_default_str();
  c->add_option("--cutting", a->cutting, "detect and apply cuts")
      ->check(CLI::IsMember({"on", "off", "both"}))
      ->capture_default_str();
  c->add_option("--input", a->input, "the study's video, or its perfect tracks (features_2d.csv)")
      ->check(CLI::IsMember({"video", "tracks", "both"}))
      ->capture_default_str();
  c->add_option("--tetrahedra", a->tetrahedra, "size of the organ meshes")
      ->check(CLI::Range(200, 1000000));
  c->add_option("--jobs", a->request.jobs,
                "studies that run beside each other (0: one a core; 1: for times a frame)")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  c->add_option("--threads", context.threads, "threads of all runs together (0: all cores)")
      ->check(CLI::Range(0, 1024));
  c->add_option("--grips", a->grips, "take depth from inferred grips (kerf method)")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  c->add_option("--outline", a->outline, "move an initial pose that contradicts the outline")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  c->add_option("--render", a->render, "write overlay.mp4 of every run")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  AddCommonOptions(c, &context);
  c->footer(
      "Examples:\n"
      "  kerf validate cases/kidney-1 cases/liver-1 --output validation\n"
      "  kerf validate cases/* --output validation --method both --input tracks\n"
      "Exit status: 0 done, 2 wrong use, 3 bad input (also: a run failed, the others are kept), "
      "130 cancelled.");
  c->callback([c, a, &context] { Run(*c, context, *a); });
}

}  // namespace kerf
