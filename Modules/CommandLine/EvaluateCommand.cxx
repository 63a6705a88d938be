#include <filesystem>

#include "Commands.h"
#include "Pipelines/EvaluatePipeline.h"

namespace kerf {
namespace {

struct EvaluateArguments {
  std::string results, truth, require, reference_labels, transform;
};

void Run(CommandContext& context, const EvaluateArguments& a) {
  context.progress = MakeShellProgress(context.quiet);
  if (a.truth.empty() && a.reference_labels.empty())
    throw UsageError("evaluate: --truth STUDY or --reference-labels FILE is needed");
  if (!a.transform.empty() && a.reference_labels.empty())
    throw UsageError("evaluate: --transform belongs to --reference-labels");
  if (!a.require.empty() && a.truth.empty())
    throw UsageError("evaluate: --require belongs to --truth");
  const auto requirements =
      a.require.empty() ? std::vector<Requirement>() : ParseRequirements(a.require);

  std::optional<Scores> scores;
  std::optional<ReferenceScores> reference;
  if (!a.truth.empty()) scores = EvaluateAgainstTruth(a.results, a.truth, *context.progress);
  if (!a.reference_labels.empty())
    reference =
        EvaluateAgainstLabels(a.results, a.reference_labels, a.transform, *context.progress);
  const auto* s = scores ? &*scores : nullptr;
  const auto* r = reference ? &*reference : nullptr;
  const std::string metrics = (std::filesystem::path(a.results) / "metrics.json").string();
  WriteMetricsFile(metrics, s, r);
  context.progress->Report(1.0, "done");
  context.result = nlohmann::json::parse(MetricsText(s, r));
  if (s) context.Print(ScoresTable(*s));
  if (r) context.Print(ReferenceTable(*r));
  context.Print("Written: " + metrics + "\nResearch use, not a medical device.");
  if (requirements.empty()) return;
  const auto unmet = UnmetRequirements(*s, requirements);
  context.result["unmet"] = unmet;
  for (const auto& sentence : unmet) context.progress->Warn("not met: " + sentence);
  if (!unmet.empty()) context.exit_status = 4;
}

}  // namespace

void AddEvaluateCommand(CLI::App& app, CommandContext& context) {
  CLI::App* c = app.add_subcommand("evaluate", "the paper's figures of a results folder");
  auto a = std::make_shared<EvaluateArguments>();
  c->add_option("RESULTS", a->results, "results folder of a replay")->required();
  c->add_option("--truth", a->truth, "study folder with truth/");
  c->add_option("--require", a->require,
                "limits at the last frame, for example dice=0.95,feature_mean=2: Dice at least, "
                "distances (mm), missed and false at most");
  c->add_option("--reference-labels", a->reference_labels,
                "label map of a second CT: 1 organ, 2 tumour, 3 inner structure");
  c->add_option("--transform", a->transform,
                "moves the second CT onto the case: 4x4 matrix as text (LPS, mm) or ITK .tfm as "
                "Slicer saves it");
  AddCommonOptions(c, &context);
  c->footer(
      "Measures: dice, lateral_mean, lateral_max, feature_mean, feature_max, organ_mean, "
      "organ_max, internal_mean, internal_max, tumour_mean, tumour_max, missed, false.\n"
      "Examples:\n"
      "  kerf evaluate results --truth study\n"
      "  kerf evaluate results --truth study --require dice=0.95,false=0 --json\n"
      "  kerf evaluate results --reference-labels after.seg.nrrd --transform after.tfm\n"
      "Exit status: 0 done, 2 wrong use, 3 bad input, 4 below what --require asked, 130 "
      "cancelled.");
  c->callback([a, &context] { Run(context, *a); });
}

}  // namespace kerf
