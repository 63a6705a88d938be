#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/StudyFolder.h"
#include "Core/Errors.h"
#include "Phantom/PhantomScenario.h"
#include "Pipelines/PhantomPipeline.h"
#include "Pipelines/TruthFiles.h"
#include "Support/CasesFolder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

std::string Content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

class PhantomFolder : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    char name[] = "/tmp/kerf-phantom-XXXXXX";
    root_ = mkdtemp(name);
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }
  static fs::path root_;
};
fs::path PhantomFolder::root_;

/// One study for all tests: the band with a cut is the quickest.
class PhantomStudy : public PhantomFolder {
 protected:
  static void SetUpTestSuite() {
    PhantomFolder::SetUpTestSuite();
    Progress progress;
    MakePhantom({PhantomScenario::BandCut, (root_ / "a study").string(), 3}, progress);
  }
  static fs::path Study() { return root_ / "a study"; }
};

TEST_F(PhantomStudy, IsReadAsAStudyAndHasTheWholeTruth) {
  const kerf::Study study = OpenStudy(Study().string());
  const PhantomSetup setup = MakePhantomSetup(PhantomScenario::BandCut, 3);
  EXPECT_EQ(study.frames, 150);
  EXPECT_EQ(study.eval_frames, setup.eval_frames);
  EXPECT_EQ(study.feature_count, 220);
  ASSERT_FALSE(study.organ_surface.empty());
  EXPECT_NEAR(ReadSurface(study.organ_surface).SignedVolume(), 120.0 * 30.0 * 4.0, 1.0);
  const CameraModel camera = ReadCameraFile(study.camera);
  EXPECT_TRUE(camera.camera_from_world.isApprox(setup.camera.camera_from_world, 1e-9));
  const TrackTable tracks = ReadTracks(study.features_2d, study.features_rest);
  EXPECT_EQ(tracks.frames, 150);
  ASSERT_EQ(tracks.id.size(), 220U);
  for (Index i = 0; i < 220; ++i)
    EXPECT_LT((camera.Project(tracks.rest.row(i)) - Vec2(tracks.rest_pixels.row(i))).norm(), 0.01);
  EXPECT_EQ(ReadLandmarks(study.landmarks).size(), 8U);
  int frames = 0;
  const auto video = OpenVideo(study.video);
  while (video->Next()) ++frames;
  EXPECT_EQ(frames, 150);

  for (const char* name :
       {"rest_organ.vtp", "cuts.json", "tracks.csv", "camera_true.yml", "landmarks_exact.csv",
        "cut0_surface_rest.vtp", "frame_00020_organ.vtp", "frame_00145_mask.png"})
    EXPECT_TRUE(fs::exists(Study() / "truth" / name)) << name;
  EXPECT_EQ(ReadSurfaceFile((Study() / "truth/frame_00145_organ.vtp").string()).space, Space::RAS);
}

TEST_F(PhantomStudy, IsTheSameBitForBit) {
  Progress progress;
  MakePhantom({PhantomScenario::BandCut, (root_ / "again").string(), 3}, progress);
  for (const auto& entry : fs::recursive_directory_iterator(Study()))
    if (entry.is_regular_file()) {
      EXPECT_EQ(Content(entry.path()),
                Content(root_ / "again" / fs::relative(entry.path(), Study())))
          << entry.path().filename();
    }
}

/// What the judge that the project did not write says of a study's own truth; empty where there is
/// no such judge.
std::string JudgeOfTruth(const fs::path& study) {
  const fs::path judge = kerf::testing::CasesFolder() / "../evaluate/evaluate.py";
  const fs::path out = study.string() + "-judge.txt";
  const std::string command = "/usr/bin/python3 -B '" + judge.string() + "' --self-test '" +
                              study.string() + "' > '" + out.string() + "' 2>&1";
  if (!fs::exists(judge) ||
      std::system("/usr/bin/python3 -c 'import vtk, cv2, scipy' 2>/dev/null") != 0)
    return {};
  EXPECT_EQ(std::system(command.c_str()), 0) << Content(out);
  return Content(out);
}

constexpr char kNoJudge[] =
    "evaluate/evaluate.py beside the cases (KERF_CASES) and python3 with vtk, cv2 and scipy are "
    "needed";

/// It accepts the layout and scores the truth as the truth.
TEST_F(PhantomStudy, TheJudgeScoresTheTruthAsTheTruth) {
  const std::string said = JudgeOfTruth(Study());
  if (said.empty()) GTEST_SKIP() << kNoJudge;
  std::istringstream text(said);
  std::string name, label, word;
  double dice = 0.0;
  text >> name >> label >> word >> dice;
  EXPECT_EQ(label, "truth");
  EXPECT_GE(dice, 0.99);
  EXPECT_NE(said.find("cuts true 1 found 1 missed 0 false 0"), std::string::npos) << said;
}

/// Two cuts, each with its own start, line and opened sheet; both the project's judge and the other
/// pair them with themselves.
TEST_F(PhantomFolder, TwoCutsHaveATruthEach) {
  const std::string study = (root_ / "two").string();
  Progress progress;
  MakePhantom({PhantomScenario::BandTwoCuts, study, 3}, progress);
  const PhantomSetup setup = MakePhantomSetup(PhantomScenario::BandTwoCuts, 3);
  const Truth truth = OpenTruth(study);
  EXPECT_EQ(truth.study.frames, 175);
  EXPECT_EQ(truth.frames.back(), 170);
  ASSERT_EQ(truth.cuts.size(), 2U);
  std::vector<DetectedCut> found;
  for (int k = 0; k < 2; ++k) {
    const PhantomCutParameters& cut = setup.motion.cuts[k];
    EXPECT_EQ(truth.cuts[k].start_frame, cut.start_frame);
    ASSERT_TRUE(truth.cuts[k].first_frame_opening_over_1mm.has_value());
    EXPECT_GT(*truth.cuts[k].first_frame_opening_over_1mm, cut.start_frame);
    EXPECT_LT(*truth.cuts[k].first_frame_opening_over_1mm, cut.start_frame + 10);
    const Points& line = truth.cuts[k].polyline_rest;
    EXPECT_NEAR((line.row(line.rows() - 1) - line.row(0)).norm(), cut.final_depth_mm, 0.01);
    EXPECT_TRUE(
        fs::exists(fs::path(study) / "truth" / ("cut" + std::to_string(k) + "_surface_rest.vtp")));
    found.insert(found.begin(), {cut.start_frame + 10.0, line});  // the other way round
  }
  const CutComparison cuts = CompareCuts(found, truth.cuts, 25.0);
  ASSERT_EQ(cuts.matched.size(), 2U);
  EXPECT_EQ(cuts.missed + cuts.false_cuts, 0);
  for (const CutMatch& match : cuts.matched) {
    EXPECT_EQ(match.detected, 1 - match.truth);
    EXPECT_NEAR(*match.timing_error_s, 0.4, 1e-9);
  }
  const std::string said = JudgeOfTruth(study);
  if (said.empty()) GTEST_SKIP() << kNoJudge;
  EXPECT_NE(said.find("cuts true 2 found 2 missed 0 false 0"), std::string::npos) << said;
}

TEST_F(PhantomFolder, ReplacesAStudyButNothingElse) {
  const fs::path other = root_ / "mine";
  fs::create_directories(other);
  std::ofstream(other / "thesis.txt") << "years of work";
  Progress progress;
  EXPECT_THROW(MakePhantom({PhantomScenario::BandCut, other.string(), 1}, progress), UsageError);
  EXPECT_EQ(Content(other / "thesis.txt"), "years of work");
  EXPECT_THROW(
      MakePhantom({PhantomScenario::BandCut, (other / "thesis.txt").string(), 1}, progress),
      InputError);
  EXPECT_THROW(
      MakePhantom({PhantomScenario::BandCut, (other / "thesis.txt/below").string(), 1}, progress),
      InputError);
}

/// Cancels after a while.
class Impatient : public Progress {
 public:
  void Report(double fraction, const std::string& what) override { cancelled_ = fraction > 0.15; }
  bool IsCancelled() const override { return cancelled_; }

 private:
  bool cancelled_ = false;
};

TEST_F(PhantomFolder, LeavesNothingBehindWhenCancelled) {
  Impatient progress;
  const fs::path folder = root_ / "cancelled" / "study";
  EXPECT_THROW(MakePhantom({PhantomScenario::BandCut, folder.string(), 1}, progress), Cancelled);
  EXPECT_TRUE(!fs::exists(folder.parent_path()) || fs::is_empty(folder.parent_path()));
}

}  // namespace
}  // namespace kerf
