#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "Core/Errors.h"
#include "Logic/CaseIO/TemporaryFolder.h"
#include "Pipelines/ValidatePipeline.h"
#include "Pipelines/ValidationTables.h"

namespace kerf {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MessageOf;
using testing::TemporaryFolder;

ValidationRun Scored(const std::string& study, bool cutting, std::map<std::string, double> values) {
  ValidationRun run;
  run.study = study;
  run.variant.cutting = cutting;
  run.scores.final_values = std::move(values);
  return run;
}

TEST(ValidationTables, StandBesideThePaper) {
  const std::vector<ValidationRun> runs = {
      Scored("liver-1", true, {{"dice", 0.97}}), Scored("liver-1", false, {{"dice", 0.91}}),
      Scored("kidney-1", true, {{"dice", 0.98}, {"feature_mean", 0.4}, {"feature_max", 3.0}}),
      Scored("mine", true, {{"dice", 0.5}})};
  const auto dice = DiceTables(runs);
  ASSERT_EQ(dice.size(), 1u);
  EXPECT_THAT(dice[0].rows[0], ElementsAre("liver-1", "0.910", "0.970", "0.906", "0.963"));
  EXPECT_THAT(dice[0].rows[2], ElementsAre("mine", "–", "0.500", "–", "–"));
  const auto distances = DistanceTables(runs);
  ASSERT_EQ(distances[0].rows.size(), 1u) << "what no run has is no row";
  EXPECT_THAT(distances[0].rows[0], ElementsAre("kidney-1", "features", "–", "0.40", "–", "3.0",
                                                "1.69 → 0.52", "11.2 → 5.4"));
  EXPECT_THAT(Markdown(dice[0]), HasSubstr("| liver-1 | 0.910 | 0.970 |"));
}

TEST(ValidationTables, MethodsAndInputsAreApart) {
  std::vector<ValidationRun> runs = {Scored("a", true, {{"dice", 0.9}}),
                                     Scored("a", true, {{"dice", 0.8}}),
                                     Scored("a", true, {{"dice", 0.7}})};
  runs[1].variant.method = Method::Reference;
  runs[2].variant.perfect_tracks = true;
  EXPECT_EQ(DiceTables(runs).size(), 3u);
  EXPECT_EQ(runs[2].variant.Name(), "kerf-tracks-cut");
}

TEST(ValidationTables, AFailedRunShowsNoFigures) {
  ValidationRun run = Scored("a", true, {{"dice", 0.9}});
  run.error = "camera.yml: broken";
  EXPECT_EQ(DiceTables({run})[0].rows[0][2], "–");
  EXPECT_EQ(CutTable({run}).rows[0][2], "failed");
  ValidationRun off = Scored("a", false, {});
  off.scores.cuts.missed = off.scores.cuts.truth = 1;
  EXPECT_EQ(CutTable({off}).rows[0][4], "–") << "detection was off: nothing was missed";
}

TEST(Validate, WrongUseIsSaidBeforeAnythingRuns) {
  TemporaryFolder folder;
  folder.Write("s/camera.yml", "");
  folder.Write("s/organ_surface.stl", "");
  Progress silent;
  ValidateRequest request;
  request.output = folder / "out";
  request.variants = {ValidationVariant()};
  EXPECT_THROW(Validate(request, silent), UsageError);
  request.studies = {folder / "s"};
  EXPECT_THAT(MessageOf<InputError>([&] { Validate(request, silent); }), HasSubstr("truth"));
  std::filesystem::create_directories(folder / "s/truth");
  request.studies = {folder / "s", folder / "s/"};
  EXPECT_THAT(MessageOf<UsageError>([&] { Validate(request, silent); }), HasSubstr("called s"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(Validate, ABrokenStudyIsReportedAndTheRestGoesOn) {
  TemporaryFolder folder;
  folder.Write("s/camera.yml", "no camera");
  folder.Write("s/organ_surface.stl", "no mesh");
  std::filesystem::create_directories(folder / "s/truth");
  ValidateRequest request;
  request.studies = {folder / "s"};
  request.output = folder / "out";
  request.variants = {{Method::Kerf, true, false}, {Method::Kerf, false, true}};
  Progress silent;
  const auto runs = Validate(request, silent);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_THAT(runs[0].error, HasSubstr("camera.yml"));
  EXPECT_THAT(runs[1].error, HasSubstr("features_2d.csv"));
  EXPECT_THAT(folder.Read("out/validation.html"), HasSubstr("2 runs failed"));
  EXPECT_THAT(folder.Read("out/validation.json"), HasSubstr("\"error\""));
}

}  // namespace
}  // namespace kerf
