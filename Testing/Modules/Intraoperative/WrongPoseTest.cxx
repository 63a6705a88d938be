// An initial pose that is wrong, through the whole of `replay`: the outline of the first picture
// pulls it in, and what comes out is better than with `--outline off`.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iostream>

#include "Adapters/Ffmpeg/VideoWriter.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "CaseIO/JournalRead.h"
#include "Pipelines/EvaluatePipeline.h"
#include "Pipelines/ReplayPipeline.h"
#include "PlannedStudy.h"
#include "Support/CasesFolder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr double kShift_mm = 3.0, kTurn_deg = 2.0;
constexpr int kTetrahedra = 12000;  // coarser ones have an outline of their own

/// Mean distance between where two cameras have the model, mm, in the camera's frame.
double PoseError_mm(const Points& model, const CameraModel& a, const CameraModel& b) {
  double sum = 0.0;
  for (Index i = 0; i < model.rows(); ++i) {
    const Vec3 p = model.row(i).transpose();
    sum += (a.camera_from_world * p - b.camera_from_world * p).norm();
  }
  return sum / static_cast<double>(model.rows());
}

/// kidney-1, whose pose is known, with another camera.yml and as many of its pictures as are asked
/// for.
class WrongPose : public ::testing::Test {
 protected:
  void SetUp() override {
    given_ = testing::CasesFolder() / "kidney-1";
    if (!fs::exists(given_)) GTEST_SKIP() << "no kidney-1 among the cases (KERF_CASES)";
    fs::remove_all(root_);
    fs::create_directories(root_ / "study");
    for (const auto& entry : fs::directory_iterator(given_))
      if (entry.path().filename() != "camera.yml" && entry.path().filename() != "video.mp4")
        fs::create_symlink(entry.path(), root_ / "study" / entry.path().filename());
    truth_ = ReadCameraFile(given_ / "camera.yml");
    case_ = testing::PlanStudyCase(given_, root_ / "case", kTetrahedra);
    model_ = ReadCase(case_).mesh.rest;
  }
  ~WrongPose() override { fs::remove_all(root_); }

  void UsePictures(int count) const {
    const auto source = OpenVideo(given_ / "video.mp4");
    VideoWriter writer(root_ / "study/video.mp4", source->Width(), source->Height(), 25);
    for (int i = 0; i < count; ++i) writer.Write(*source->Next()->image);
    writer.Finish();
  }
  /// Moves and turns the true pose about the organ's middle.
  void SpoilPose(const Vec3& shift, const Vec3& axis) const {
    CameraModel wrong = truth_;
    const Vec3 middle = truth_.camera_from_world * Vec3(model_.colwise().mean().transpose());
    Eigen::Isometry3d by = Eigen::Isometry3d::Identity();
    by.translate(middle + kShift_mm * shift.normalized());
    by.rotate(Eigen::AngleAxisd(kTurn_deg * M_PI / 180.0, axis.normalized()));
    by.translate(-middle);
    wrong.camera_from_world = by * truth_.camera_from_world;
    WriteCameraFile(root_ / "study/camera.yml", wrong);
  }
  std::string Run(bool outline) const {
    ReplayRequest request;
    request.study = root_ / "study";
    request.results = root_ / (outline ? "on" : "off");
    request.case_folder = case_;
    request.drawing = ReplayRequest::Drawing::None;
    request.outline = outline;
    Progress silent;
    Replay(request, silent);
    return request.results;
  }
  double UsedPoseError_mm(const std::string& results) const {
    return PoseError_mm(model_, ReadCameraFile(results + "/camera.yml"), truth_);
  }

  const fs::path root_ =
      fs::temp_directory_path() / ("kerf-wrong-pose-" + std::to_string(getpid()));
  fs::path given_;
  CameraModel truth_;
  std::string case_;
  Points model_;
};

TEST_F(WrongPose, IsPulledInFromEverySideAndTheResultsSayWhatWasUsed) {
  UsePictures(3);
  const struct {
    Vec3 shift, axis;
  } wrongs[] = {{{1, 0.3, 0}, {0, 1, 0}}, {{0, -1, 0.2}, {1, 0, 0}}, {{-0.6, 0.8, 0}, {0, 0, 1}}};
  for (const auto& wrong : wrongs) {
    SpoilPose(wrong.shift, wrong.axis);
    const double with = UsedPoseError_mm(Run(true)), without = UsedPoseError_mm(Run(false));
    EXPECT_GT(without, 2.5);
    EXPECT_LT(with, 0.6 * without);
    int told = 0;
    for (const JournalEntry& entry : ReadJournal(root_ / "on/journal.jsonl"))
      if (entry.event == "registration accepted") told += entry.Number("outline_shift_mm") > 1.0;
    EXPECT_EQ(told, 1);
  }
}

TEST_F(WrongPose, TheRightPoseIsLeftAlone) {
  UsePictures(3);
  WriteCameraFile(root_ / "study/camera.yml", truth_);
  EXPECT_LT(UsedPoseError_mm(Run(true)), 1e-9);
}

TEST_F(WrongPose, TheWholeStudyEndsNearerToTheTruth) {
  fs::create_symlink(given_ / "video.mp4", root_ / "study/video.mp4");
  SpoilPose({1, -0.5, 0}, {0.3, 1, 0});
  Progress silent;
  const auto judge = [&](bool outline) {
    return EvaluateAgainstTruth(Run(outline), given_, silent).final_values;
  };
  auto with = judge(true), without = judge(false);
  std::cout << "features " << with["feature_mean"] << " mm with the outline, "
            << without["feature_mean"] << " without; Dice " << with["dice"] << ", "
            << without["dice"] << '\n';
  EXPECT_LT(with["feature_mean"], 0.85 * without["feature_mean"]);
  EXPECT_GT(with["dice"], without["dice"] + 0.04);
}

}  // namespace
}  // namespace kerf
