#include <fmt/format.h>

#include <chrono>
#include <filesystem>

#include "Commands.h"
#include "Pipelines/DemoPipeline.h"
#include "Pipelines/EvaluatePipeline.h"

namespace kerf {
namespace {

void Run(CommandContext& context, const std::string& output) {
  context.progress = MakeShellProgress(context.quiet);
  const auto start = std::chrono::steady_clock::now();
  const DemoResult demo = RunDemo(output, *context.progress);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  context.progress->Report(1.0, "done");
  const auto absolute = [](const std::string& path) {
    return path.empty() ? path : std::filesystem::absolute(path).lexically_normal().string();
  };
  context.result = nlohmann::json::parse(MetricsText(&demo.scores, nullptr));
  context.result["study_folder"] = absolute(demo.study);
  context.result["case_folder"] = absolute(demo.case_folder);
  context.result["results_folder"] = absolute(demo.results);
  context.result["overlay"] = absolute(demo.overlay);
  context.result["report"] = absolute(demo.report);
  context.result["gate"] = ToString(demo.replay.final_gate);
  context.result["seconds"] = seconds;
  context.Print(
      fmt::format("A synthetic kidney with a tumour: CT segmented, {} tetrahedra, {} frames "
                  "replayed in {:.0f} s\n"
                  "({:.1f} ms a frame in the median, 99 %: {:.1f} ms); gate {} at the end.\n",
                  demo.tetrahedra, demo.replay.frames, seconds, demo.replay.median_ms,
                  demo.replay.p99_ms, ToString(demo.replay.final_gate)));
  context.Print(ScoresTable(demo.scores));
  context.Print("Video:  " +
                (demo.overlay.empty() ? "none (nothing can be drawn on this machine)"
                                      : absolute(demo.overlay)) +
                "\nReport: " + absolute(demo.report) + "\nResearch use, not a medical device.");
}

}  // namespace

void AddDemoCommand(CLI::App& app, CommandContext& context) {
  CLI::App* c = app.add_subcommand(
      "demo", "a synthetic patient from CT to report: phantom, plan, replay, evaluate");
  auto output = std::make_shared<std::string>("kerf-demo");
  c->add_option("--output", *output,
                "folder for everything that is made; an older demo there is replaced")
      ->capture_default_str();
  AddCommonOptions(c, &context);
  c->footer(
      "Examples:\n"
      "  kerf demo\n"
      "  kerf demo --output /data/kerf-demo --json\n"
      "Below the folder: study/ (the patient, with truth), case/ (planned), results/ (overlay.mp4, "
      "report.html, ...).\n"
      "Exit status: 0 done, 2 wrong use, 3 bad input, 130 cancelled.");
  c->callback([output, &context] { Run(context, *output); });
}

}  // namespace kerf
