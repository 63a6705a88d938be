#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>

#include "Adapters/OpenCv/CameraFile.h"
#include "Core/Errors.h"
#include "Support/CasesFolder.h"
#include "Support/TestCameras.h"
#include "TemporaryFolder.h"

namespace kerf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::MessageOf;
using testing::TemporaryFolder;

CameraModel Example() {
  CameraModel camera = testing::Laparoscope(Eigen::Translation3d(7.5, 138.7, 130.2) *
                                            Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  camera.fx = 905.123456789012;  // every digit has to come back
  return camera;
}

std::string Matrix(const std::string& key, int rows, int columns, const std::string& data) {
  return key + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
         "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ " + data + " ]\n";
}

const std::string kHead = "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n";
const std::string kMatrix =
    Matrix("camera_matrix", 3, 3, "500., 0., 320., 0., 500., 240., 0., 0., 1.");
const std::string kPose = "1., 0., 0., 1., 0., 1., 0., 2., 0., 0., 1., 300., 0., 0., 0., 1.";

TEST(CameraFile, ComesBackToTheBit) {
  TemporaryFolder folder;
  const CameraModel camera = Example();
  WriteCameraFile(folder / "camera.yml", camera);
  const CameraModel back = ReadCameraFile(folder / "camera.yml");
  EXPECT_EQ(back.fx, camera.fx);
  EXPECT_EQ(back.distortion, camera.distortion);
  EXPECT_EQ(back.width, 960);
  EXPECT_EQ(back.camera_from_world.matrix(), camera.camera_from_world.matrix());
  EXPECT_EQ(folder.EntryCount(), 1u);
}

TEST(CameraFile, SaysHowOldTheCalibrationIs) {
  TemporaryFolder folder;
  std::tm day{};
  day.tm_year = 126, day.tm_mon = 10, day.tm_mday = 23, day.tm_hour = 12;
  const std::time_t now = timegm(&day);
  EXPECT_EQ(CalibrationAge_days("2026-11-23T08:30:00Z", now), 0);
  EXPECT_EQ(CalibrationAge_days("2026-10-09", now), 45);
  EXPECT_EQ(CalibrationAge_days("Fri Oct  9 11:02:33 2026", now), 45) << "as OpenCV writes it";
  EXPECT_EQ(CalibrationAge_days("2027-01-01", now), -39);
  for (const char* nothing : {"", "yesterday", "2026", "2026-13-45"})
    EXPECT_EQ(CalibrationAge_days(nothing, now), std::nullopt) << nothing;
  // A copy is as old as what it is a copy of.
  const std::string old =
      folder.Write("old.yml", kHead + "calibration_time: \"Fri Oct  9 11:02:33 2026\"\n" + kMatrix);
  WriteCameraFile(folder / "copy.yml", Example(), ReadCalibrationTime(old));
  EXPECT_EQ(ReadCalibrationTime(folder / "copy.yml"), "Fri Oct  9 11:02:33 2026");
  EXPECT_EQ(ReadCameraFile(folder / "copy.yml").fx, Example().fx);
  WriteCameraFile(folder / "unknown.yml", Example());
  EXPECT_EQ(ReadCalibrationTime(folder / "unknown.yml"), "");
  EXPECT_EQ(ReadCalibrationTime(
                folder.Write("odd.yml", kHead + "calibration_time: \"a\\\"b\"\n" + kMatrix)),
            "")
      << "would break the file that it is written into";
}

TEST(CameraFile, ReadsPosesOfBothFrames) {
  TemporaryFolder folder;
  const CameraModel lps = ReadCameraFile(
      folder.Write("l.yml", kHead + kMatrix + Matrix("camera_from_world", 4, 4, kPose)));
  const CameraModel ras =
      ReadCameraFile(folder.Write("r.yml", kHead + kMatrix + Matrix("T_cam_from_ct", 4, 4, kPose)));
  const Vec3 p(10, 20, 5);
  EXPECT_LT((lps.Project(p) - ras.Project(Vec3(-10, -20, 5))).norm(), 1e-9);
  EXPECT_EQ(lps.distortion[0], 0.0) << "no coefficients: no distortion";
}

TEST(CameraFile, NamesTheKey) {
  TemporaryFolder folder;
  const std::string pose = Matrix("camera_from_world", 4, 4, kPose);
  auto message = [&](const std::string& text) {
    return MessageOf<InputError>([&] { ReadCameraFile(folder.Write("c.yml", text)); });
  };
  EXPECT_EQ(message(kHead + kMatrix + pose), "");
  const std::pair<std::string, const char*> broken[] = {
      {kHead + pose, "camera_matrix: is missing"},
      {kHead + kMatrix, "camera_from_world: is missing"},
      {"%YAML:1.0\n---\n" + kMatrix + pose, "image_width"},
      {kHead + Matrix("camera_matrix", 2, 3, "1., 0., 0., 0., 1., 0.") + pose, "2x3"},
      {kHead + Matrix("camera_matrix", 3, 3, "500., 0., 320., 0., .Nan, 240., 0., 0., 1.") + pose,
       "camera_matrix"},
      {kHead + Matrix("camera_matrix", 3, 3, "-5., 0., 320., 0., 500., 240., 0., 0., 1.") + pose,
       "camera_matrix"},
      {kHead + Matrix("camera_matrix", 3, 3, "500., 3., 320., 0., 500., 240., 0., 0., 1.") + pose,
       "skew"},
      {kHead + kMatrix + Matrix("camera_from_world", 3, 4, kPose.substr(0, 63)),
       "camera_from_world"},
      {kHead + kMatrix +
           Matrix("camera_from_world", 4, 4,
                  "2., 0., 0., 1., 0., 1., 0., 2., 0., 0., 1., 3., 0., 0., 0., 1."),
       "rigid"},
      {kHead + kMatrix +
           Matrix("camera_from_world", 4, 4,
                  "-1., 0., 0., 1., 0., 1., 0., 2., 0., 0., 1., 3., 0., 0., 0., 1."),
       "rigid"},
      {kHead + kMatrix + pose +
           Matrix("distortion_coefficients", 1, 8, "0., 0., 0., 0., 0., 1., 0., 0."),
       "distortion_coefficients"},
      {kHead + "camera_matrix: 5\n" + pose, "camera_matrix"},
      {"garbage: [", "c.yml"},
      {"", "c.yml"}};
  for (const auto& [text, element] : broken)
    EXPECT_THAT(message(text), AllOf(HasSubstr("c.yml"), HasSubstr(element))) << text;
  EXPECT_THAT(MessageOf<InputError>([&] { ReadCameraFile(folder / "none.yml"); }),
              HasSubstr("cannot be opened"));
}

TEST(CameraFile, IntrinsicsNeedNoPose) {
  TemporaryFolder folder;
  const CameraModel camera = ReadCameraIntrinsics(folder.Write("c.yml", kHead + kMatrix));
  EXPECT_EQ(camera.fx, 500.0);
  EXPECT_TRUE(camera.camera_from_world.matrix().isIdentity());
}

TEST(CameraFile, LandmarksOfAStudyProjectOntoTheirPixels) {
  const std::filesystem::path study = kerf::testing::CasesFolder() / "kidney-1";
  if (!std::filesystem::exists(study)) GTEST_SKIP() << "no study " << study << " (set KERF_CASES)";
  const CameraModel camera = ReadCameraFile((study / "camera.yml").string());
  // First point of features_rest.csv: -42.966,32.121,105.734 (RAS) at 557.83, 397.75.
  EXPECT_LT((camera.Project(Vec3(42.966, -32.121, 105.734)) - Vec2(557.83, 397.75)).norm(), 0.05);
}

}  // namespace
}  // namespace kerf
