// What goes wrong around a session costs neither the session nor what was recorded.
#include <gtest/gtest.h>

#include <ctime>
#include <fstream>

#include "Adapters/OpenCv/CameraFile.h"
#include "CaseIO/JournalRead.h"
#include "CaseIO/Markups.h"
#include "Core/Errors.h"
#include "DeskScene.h"
#include "Pipelines/ReplayPipeline.h"
#include "Pipelines/SessionPlayback.h"
#include "Pipelines/SessionRecorder.h"
#include "Session/ResectionFiles.h"
#include "Support/FileSizeLimit.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using namespace testing;

void Start(const PhantomCase& phantom, IntraoperativeDesk* desk) {
  phantom.OpenFor(desk);
  desk->BeginExposure();
  desk->Accept({});
  ASSERT_TRUE(Within(20, [&] { return desk->Latest() && desk->Latest()->frame.index >= 5; }));
}

TEST(Desk, ADiskThatTakesNothingDoesNotKeepTheSessionFromRunning) {
  const PhantomCase phantom(2000);
  // As a full or read-only disk: no folder for sessions can be made.
  std::ofstream(phantom.Folder() + "/sessions") << "in the way";
  IntraoperativeDesk desk;
  Start(phantom, &desk);
  EXPECT_FALSE(desk.Latest()->recording);
  EXPECT_NE(desk.Latest()->recording_problem.find("sessions"), std::string::npos);
  EXPECT_NE(desk.Latest()->gate, GateState::Off);
  desk.Stop();
  EXPECT_EQ(desk.SessionPath(), "");
  EXPECT_FALSE(desk.RecordingProblem().empty());
}

TEST(Desk, ADiskThatFillsUpLosesNothingThatWasWritten) {
  const PhantomCase phantom(2000);
  IntraoperativeDesk desk;
  Start(phantom, &desk);
  // From here on the results cannot be written: a folder stands where the table goes.
  const fs::path session = desk.SessionPath();
  fs::create_directories(session / "timing.csv" / "in-the-way");
  desk.Stop();
  EXPECT_FALSE(desk.RecordingProblem().empty());
  EXPECT_GE(ReadRecordedFrames(session.string()).size(), 6u);
  EXPECT_FALSE(ReadJournal((session / "journal.jsonl").string()).empty());
  // It counts as broken off, and is offered.
  ASSERT_EQ(desk.Unfinished().size(), 1u);
  desk.BeginExposure();
  EXPECT_EQ(desk.Resume(session.string()), 0);
}

TEST(Desk, ACutDrawnAfterTheDiskFilledUpIsThereWhenRegisteredAgain) {
  const PhantomCase phantom(2000);
  IntraoperativeDesk desk;
  Start(phantom, &desk);
  {
    const testing::FileSizeLimit full(0);
    ASSERT_TRUE(Within(20, [&] { return !desk.Latest()->recording_problem.empty(); }));
    IntraoperativeDecision drawn;
    drawn.kind = IntraoperativeDecision::Kind::DrawCut;
    drawn.stroke.resize(2, 2);
    drawn.stroke << 330, 340, 330, 200;
    desk.Post(drawn);
    ASSERT_TRUE(Within(20, [&] { return desk.Latest()->cuts.size() == 1; }));
    desk.Stop();
  }
  desk.KeepCutsForNextRun();
  desk.BeginExposure();
  desk.Accept({});
  ASSERT_TRUE(Within(20, [&] { return desk.Latest() && !desk.Latest()->cuts.empty(); }));
  EXPECT_TRUE(desk.Latest()->cuts[0].drawn);
  EXPECT_EQ(desk.Latest()->cuts[0].state, CutItem::State::Applied);
  EXPECT_TRUE(desk.Latest()->recording);
}

TEST(Desk, APictureThatCannotBeKeptNamesTheFolder) {
  const PhantomCase phantom(2000);
  IntraoperativeDesk desk;
  Start(phantom, &desk);
  std::ofstream(desk.SessionPath() + "/snapshots") << "in the way";
  const auto now = desk.Latest();
  try {
    desk.KeepPicture(*now->frame.image, 3, now->captured);
    FAIL() << "kept";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("/snapshots: cannot be made: "), std::string::npos)
        << error.what();
  }
}

TEST(Desk, AVideoThatCannotBeReadToItsEndIsNotKeptAsAWholeOne) {
  const PhantomCase phantom(2000);
  SessionFolder session;
  session.root = phantom.Folder() + "/sessions/broken";
  fs::create_directories(session.root);
  try {
    // On another file system, and every read of it is an error.
    SessionRecorder recorder(session, {}, {}, "/proc/self/mem", {});
    FAIL() << "recorded";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("/proc/self/mem: cannot be read: "), std::string::npos)
        << error.what();
  }
}

TEST(Desk, PicturesOfOneFrameStayInTheOrderInWhichTheyWereKept) {
  const PhantomCase phantom(2000);
  IntraoperativeDesk desk;
  Start(phantom, &desk);
  const auto now = desk.Latest();
  std::vector<std::string> kept = {desk.KeepPicture(*now->frame.image, 3, now->captured)};
  for (int again = 2; again <= 12; ++again) {
    kept.push_back(desk.KeepPicture(*now->frame.image, 3, now->captured));
    EXPECT_NE(kept.back().find("frame_000003-" + std::to_string(again) + ".png"),
              std::string::npos);
  }
  kept.push_back(desk.KeepPicture(*now->frame.image, 20, now->captured));
  kept.push_back(desk.KeepPicture(*now->frame.image, -1, now->captured));  // time_….png
  EXPECT_EQ(KeptPictures(desk.SessionPath()), kept);
}

TEST(Desk, ABrokenCaseAndAWrongCameraFileChangeNothing) {
  const PhantomCase phantom(2000);
  IntraoperativeDesk desk;
  phantom.OpenFor(&desk);
  const std::string camera = desk.CameraFile();
  EXPECT_THROW(desk.UseCamera(phantom.Folder() + "/case.json"), InputError);
  EXPECT_EQ(desk.CameraFile(), camera);
  desk.BeginExposure();  // with the camera of before
  std::ofstream(phantom.Folder() + "/organ.vtu", std::ios::binary) << "broken";
  EXPECT_THROW(IntraoperativeDesk::ReadPlanned(phantom.Folder()), InputError);
  EXPECT_TRUE(desk.HasCase());
}

/// What a journal says of cuts, with the frames.
std::vector<std::string> CutsOf(const std::string& folder) {
  std::vector<std::string> cuts;
  for (const JournalEntry& entry : ReadJournal(folder + "/journal.jsonl")) {
    if (entry.event.rfind("cut ", 0) != 0) continue;
    std::string line = std::to_string(entry.frame) + ' ' + entry.event;
    for (const double x : entry.Numbers("point_rest_mm")) line += ' ' + std::to_string(x);
    cuts.push_back(line);
  }
  return cuts;
}

TEST(Desk, TheAgeOfTheCalibrationIsWhatItsFileSays) {
  const PhantomCase phantom(4000);
  IntraoperativeDesk desk;
  phantom.OpenFor(&desk);
  const CameraModel camera = ReadCameraFile(PhantomCase::Study() + "/camera.yml");
  const std::string file = phantom.Folder() + "/calibration.yml";
  const auto said = [&](const std::string& calibrated) {
    WriteCameraFile(file, camera, calibrated);  // now, whatever it says
    desk.UseCamera(file);
    for (const CheckInItem& item : desk.CheckIn(desk.Pseudonym()))
      if (item.text.rfind("Calibration", 0) == 0)
        return (item.level == CheckInItem::Level::Ok ? "ok: " : "warned: ") + item.text;
    return std::string("nothing");
  };
  const auto day = [](int days_ago) {
    const std::time_t then = std::time(nullptr) - 86400 * days_ago - 3600;
    char text[32];
    std::strftime(text, sizeof text, "%a %b %d %H:%M:%S %Y", std::gmtime(&then));
    return std::string(text);
  };
  EXPECT_EQ(said(day(3)), "ok: Calibration calibration.yml, 3 days old.");
  EXPECT_EQ(said(day(45)), "warned: Calibration calibration.yml, 45 days old.");
  EXPECT_EQ(said(""), "warned: Calibration calibration.yml: the file does not say how old it is.");
  EXPECT_NE(said(day(-5)).find("in the future"), std::string::npos);
  fs::remove(file);
}

TEST(Desk, ThePlanIsHeldAgainstTheCutLiveAndInThePlayback) {
  const PhantomCase phantom(4000);
  ResectionPlan plan;
  Points line(3, 3);
  {  // across the middle of the organ, seen from the camera
    IntraoperativeDesk desk;
    phantom.OpenFor(&desk);
    const SurfaceMesh& organ = desk.Planned().organ_surface;
    const CameraModel camera = ReadCameraFile(PhantomCase::Study() + "/camera.yml");
    const Vec3 center = organ.points.colwise().mean().transpose();
    const Vec3 view = camera.ViewDirection();
    const Vec3 side = camera.camera_from_world.linear().row(1).transpose();
    const SurfaceTree tree(organ);
    for (int i = 0; i < 3; ++i) {
      const auto hit = tree.FirstHit({center + 12.0 * (i - 1) * side - 200 * view, view});
      ASSERT_TRUE(hit);
      line.row(i) = hit->point.transpose();
    }
    plan.line = line;
    plan.direction = view;
    plan.depth_mm = 80;
    plan.margin_mm = 7;
    CaseWriter writer = CaseWriter::Update(phantom.Folder());
    StageResectionPlan(plan, &writer);
    writer.Commit();
  }
  std::string session;
  {
    IntraoperativeDesk desk;
    Start(phantom, &desk);
    EXPECT_FALSE(desk.Latest()->planned_lines.empty());
    EXPECT_EQ(desk.Latest()->planned_margin_mm, 7.0);
    EXPECT_EQ(desk.PlannedMargin_mm(), 7.0);
    EXPECT_TRUE(std::isnan(desk.Latest()->deviation.mean_mm));
    IntraoperativeDecision drawn;
    drawn.kind = IntraoperativeDecision::Kind::DrawCut;
    drawn.line = line;
    const Vec3 aside = plan.direction.cross(Vec3(line.row(2) - line.row(0))).normalized();
    drawn.line.rowwise() += 3.0 * aside.transpose();
    drawn.direction = plan.direction;
    desk.Post(drawn);
    ASSERT_TRUE(Within(30, [&] { return std::isfinite(desk.Latest()->deviation.mean_mm); }));
    EXPECT_NEAR(desk.Latest()->deviation.mean_mm, 3.0, 0.8);
    session = desk.SessionPath();
    desk.Stop();
  }
  SessionPlayback playback(session);
  ASSERT_TRUE(Within(120, [&] {
    return playback.Ready() == playback.FrameCount() || !playback.Problem().empty();
  }));
  EXPECT_EQ(playback.Problem(), "");
  EXPECT_NEAR(playback.At(playback.FrameCount() - 1)->deviation.mean_mm, 3.0, 0.8);
  EXPECT_TRUE(std::isnan(playback.At(0)->deviation.mean_mm));
  ASSERT_FALSE(playback.Events().empty());
  bool drawn = false, applied = false;
  for (const PlaybackEvent& event : playback.Events()) {
    drawn |= event.words == "cut drawn";
    applied |= event.words == "cut applied: cut 1";
  }
  EXPECT_TRUE(drawn && applied);
  bool reported = false;
  for (const JournalEntry& entry : ReadJournal(session + "/journal.jsonl"))
    if (entry.event == "cut applied") {
      reported = true;
      EXPECT_EQ(entry.Numbers("point_rest_mm").size(), 3u);
      EXPECT_TRUE(entry.Text("reason"));
      for (const char* key : {"new_vertices", "new_tetrahedra", "smallest_dihedral_deg"})
        EXPECT_GT(entry.Number(key).value_or(0), 0) << key;
    }
  EXPECT_TRUE(reported);
  ReplayRequest again;
  again.study = session;
  again.results = phantom.Folder() + "/replayed";
  again.drawing = ReplayRequest::Drawing::None;
  Progress silent;
  Replay(again, silent);
  EXPECT_EQ(CutsOf(again.results), CutsOf(session));
  // Any order gives the same.
  const auto late = playback.At(playback.FrameCount() - 1), early = playback.At(2);
  EXPECT_TRUE(playback.At(playback.FrameCount() - 1)->organ.points == late->organ.points);
  EXPECT_EQ(playback.At(2)->frame.image->data, early->frame.image->data);
  EXPECT_EQ(early->frame.index, 2);
}

}  // namespace
}  // namespace kerf
