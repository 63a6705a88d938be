/// kerf evaluate against the figures of an independent judge (baselines.json beside the simulated
/// studies): the truth itself, and the rest state ("no registration at all").
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "CaseIO/CaseFolder.h"
#include "Core/Errors.h"
#include "Logic/CaseIO/TemporaryFolder.h"
#include "Pipelines/EvaluatePipeline.h"
#include "Support/CasesFolder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::MessageOf;
using testing::TemporaryFolder;

nlohmann::json ReadJson(const fs::path& file) {
  std::ifstream in(file);
  return nlohmann::json::parse(in);
}

std::string FrameName(int frame, const std::string& what) {
  char text[64];
  std::snprintf(text, sizeof text, "frame_%05d_%s", frame, what.c_str());
  return text;
}

/// The truth's surfaces, exact feature positions and cuts as if a program had found them.
void WriteTruthAsResults(const fs::path& study, const TemporaryFolder& out, bool features) {
  for (const auto& entry : fs::directory_iterator(study / "truth")) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("frame_", 0) == 0 && entry.path().extension() == ".vtp")
      fs::copy(entry.path(), out / name);
  }
  const auto truth = ReadJson(study / "truth/cuts.json");
  nlohmann::json cuts = {{"space", "RAS"}, {"cuts", nlohmann::json::array()}};
  for (const auto& cut : truth["cuts"])
    cuts["cuts"].push_back({{"detected_frame", std::floor(cut["start_frame"].get<double>())},
                            {"polyline_rest", cut["polyline_rest"]}});
  out.Write("cuts.json", cuts.dump());
  if (features) fs::copy(study / "truth/tracks.csv", out / "features.csv");
}

class Agreement : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    study_ = testing::CasesFolder() / GetParam();
    if (!fs::exists(study_ / "truth") || !fs::exists(testing::CasesFolder() / "baselines.json"))
      GTEST_SKIP() << "no study " << study_ << " (set KERF_CASES)";
    baselines_ = ReadJson(testing::CasesFolder() / "baselines.json")[GetParam()];
  }
  void ExpectAgreement(const Scores& scores, const nlohmann::json& judge) {
    for (const auto& [name, value] : judge["final"].items()) {
      ASSERT_TRUE(scores.final_values.count(name)) << name;
      const double expected = value.get<double>(), found = scores.final_values.at(name);
      // Exact positions are given to 0.01 mm.
      const double tolerance = name == "dice" ? 0.002 : 0.02 + 0.001 * expected;
      EXPECT_NEAR(found, expected, tolerance) << name;
    }
    ASSERT_EQ(scores.frames.size(), judge["frames"].size());
    for (std::size_t i = 0; i < scores.frames.size(); ++i)
      EXPECT_NEAR(scores.frames[i].values.at("dice"), judge["frames"][i]["dice"].get<double>(),
                  0.002)
          << "frame " << scores.frames[i].frame;
    EXPECT_EQ(scores.cuts.missed, judge["cuts"]["missed"].get<int>());
    EXPECT_EQ(scores.cuts.false_cuts, judge["cuts"]["false"].get<int>());
  }
  fs::path study_;
  nlohmann::json baselines_;
  Progress silent_;
};

TEST_P(Agreement, TheTruthItself) {
  TemporaryFolder results;
  WriteTruthAsResults(study_, results, true);
  const Scores scores = EvaluateAgainstTruth(results.Path(), study_.string(), silent_);
  ExpectAgreement(scores, baselines_["truth"]);
  EXPECT_GT(scores.final_values.at("dice"), 0.995);
  EXPECT_LT(scores.final_values.at("organ_max"), 1e-9);
}

TEST_P(Agreement, TheRestState) {
  TemporaryFolder results;
  const auto info = ReadJson(study_ / "case.json");
  for (const std::string what : {"organ", "internal", "tumour"}) {
    // At rest the faces of the cut coincide: with them or without, what is seen and measured is
    // nearly the same.
    const fs::path rest =
        study_ / "truth" / (what == "organ" ? FrameName(20, "organ.vtp") : "rest_" + what + ".vtp");
    if (!fs::exists(rest)) continue;
    for (int frame : info["eval_frames"]) fs::copy(rest, results / FrameName(frame, what + ".vtp"));
  }
  results.Write("cuts.json", R"({"cuts": []})");
  std::string features = "frame,id,x_mm,y_mm,z_mm\n";
  std::ifstream in(study_ / "features_rest.csv");
  std::string line;
  std::getline(in, line);
  const int last = info["eval_frames"].back();
  while (std::getline(in, line)) {
    // id,use,x,y,z,u,v (RAS) → frame,id,x,y,z (LPS)
    std::istringstream fields(line);
    std::vector<std::string> f(1);
    while (std::getline(fields, f.back(), ',')) f.emplace_back();
    if (f[1] != "1") continue;
    features += std::to_string(last) + "," + f[0] + "," + std::to_string(-std::stod(f[2])) + "," +
                std::to_string(-std::stod(f[3])) + "," + f[4] + "\n";
  }
  results.Write("features.csv", features);
  ExpectAgreement(EvaluateAgainstTruth(results.Path(), study_.string(), silent_),
                  baselines_["rest"]);
}

INSTANTIATE_TEST_SUITE_P(Studies, Agreement,
                         ::testing::Values("silicone-left", "kidney-1", "liver-1"),
                         [](const auto& info) {
                           std::string name = info.param;
                           name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
                           return name;
                         });

TEST(EvaluateAgainstTruth, NamesWhatIsMissing) {
  const fs::path study = testing::CasesFolder() / "silicone-left";
  if (!fs::exists(study)) GTEST_SKIP() << "no study " << study << " (set KERF_CASES)";
  TemporaryFolder results, other;
  Progress silent;
  auto message = [&](const std::string& r, const std::string& s) {
    return MessageOf<InputError>([&] { EvaluateAgainstTruth(r, s, silent); });
  };
  EXPECT_THAT(message(results.Path(), study.string()), HasSubstr("frame_00020_organ.vtp"));
  EXPECT_THAT(message(results / "none", study.string()), HasSubstr("no folder"));
  for (const char* name : {"camera.yml", "organ_surface.stl", "case.json"})
    fs::copy(study / name, other / name);
  EXPECT_THAT(message(results.Path(), other.Path()), HasSubstr("truth"));
}

TEST(EvaluateAgainstTruth, MetricsComeBack) {
  const fs::path study = testing::CasesFolder() / "silicone-left";
  if (!fs::exists(study)) GTEST_SKIP() << "no study " << study << " (set KERF_CASES)";
  TemporaryFolder results;
  Progress silent;
  WriteTruthAsResults(study, results, false);
  const Scores scores = EvaluateAgainstTruth(results.Path(), study.string(), silent);
  EXPECT_FALSE(scores.final_values.count("feature_mean")) << "nothing tells feature positions";
  WriteMetricsFile(results / "metrics.json", &scores, nullptr);
  const Scores back = ReadMetricsFile(results / "metrics.json");
  EXPECT_EQ(back.final_values, scores.final_values);
  EXPECT_EQ(back.study, "silicone-left");
  ASSERT_EQ(back.cuts.matched.size(), 1u);
  EXPECT_EQ(back.cuts.matched[0].timing_error_s, scores.cuts.matched[0].timing_error_s);
  EXPECT_THAT(ScoresTable(back), HasSubstr("Dice of silhouettes"));
}

}  // namespace
}  // namespace kerf
