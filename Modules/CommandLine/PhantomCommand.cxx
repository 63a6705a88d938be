#include <fmt/format.h>

#include "Commands.h"
#include "Pipelines/PhantomPipeline.h"

namespace kerf {

namespace {

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const auto scenario : kPhantomScenarios) names.push_back(ToString(scenario));
  return names;
}

}  // namespace

void AddPhantomCommand(CLI::App& app, CommandContext& context) {
  CLI::App* c = app.add_subcommand("phantom", "a synthetic patient as a study folder with truth");
  struct Arguments {
    std::string scenario;
    PhantomRequest request;
  };
  auto a = std::make_shared<Arguments>();
  c->add_option(
       "--scenario", a->scenario,
       "kidney-cut: cut while being pulled; -curved: along a curve; -through: into two pieces;\n"
       "-two-cuts: two from the same border, one after the other; kidney-nocut: pulled, bent and\n"
       "twisted; band-cut: silicone band, cut from one edge; band-through: into two pieces;\n"
       "band-two-cuts: from either edge, one after the other; band-stretch: stretched by 70 %")
      ->required()
      ->check(CLI::IsMember(Names()));
  c->add_option("--output", a->request.output,
                "study folder to be made; an older study there is replaced")
      ->required();
  c->add_option("--seed", a->request.seed, "varies noise and textures")->capture_default_str();
  AddCommonOptions(c, &context);
  c->footer(
      "Examples:\n"
      "  kerf phantom --scenario kidney-cut --output my-study\n"
      "  kerf phantom --scenario band-stretch --output negative --seed 7\n"
      "The layout is described in docs/reference/phantom.md.");
  c->callback([a, &context] {
    context.progress = MakeShellProgress(context.quiet);
    a->request.scenario = ParsePhantomScenario(a->scenario);
    const PhantomResult result = MakePhantom(a->request, *context.progress);
    context.progress->Report(1.0, "done");
    context.result = {{"study", a->request.output},
                      {"scenario", a->scenario},
                      {"seed", a->request.seed},
                      {"frames", result.frames},
                      {"final_opening_mm", result.final_opening_mm}};
    context.Print(fmt::format("{} frames, the cut opens to {:.1f} mm\nStudy: {}", result.frames,
                              result.final_opening_mm, a->request.output));
  });
}

}  // namespace kerf
