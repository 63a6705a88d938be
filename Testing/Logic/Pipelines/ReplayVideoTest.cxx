/// Broken video through the whole of `replay`: refused by file and element before the work begins,
/// or kept as far as it goes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "Adapters/Ffmpeg/VideoWriter.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/ResultsFiles.h"
#include "Core/Errors.h"
#include "Logic/OpenCv/SyntheticVideo.h"
#include "Pipelines/ReplayPipeline.h"
#include "Registration/OrganMask.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using test::Scratch;
using ::testing::HasSubstr;

constexpr int kWidth = 240, kHeight = 160, kFrames = 12;

/// A small block of silicone at rest before a calibrated camera; the video is each test's own.
class ReplayVideo : public ::testing::Test {
 protected:
  ReplayVideo() : folder_("replay-video") {
    fs::create_directories(folder_ / "study");
    WriteCameraFile(Study("camera.yml"), camera_);
    const TetMesh block = testing::BoxMesh(Vec3(70, 40, 12), 7, 4, 2);
    const SurfaceMesh surface = BoundarySurface(block, block.rest);
    WriteSurface(surface, Study("organ_surface.vtp"));
    picture_ = test::Tissue(kWidth, kHeight, 4);
    cv::Mat ground(kHeight, kWidth, CV_8UC3, cv::Scalar(60, 110, 40));
    ground.copyTo(picture_, 255 - ViewOf(ProjectedMask(surface, camera_)));
  }
  std::string Study(const std::string& name) const { return folder_ / ("study/" + name); }
  std::string Results(const std::string& name) const { return folder_ / ("results/" + name); }
  void NameVideo(const std::string& file) const {
    std::ofstream(Study("case.json")) << R"({"video": {"file": ")" << file << "\"}}";
  }
  void WriteH264(const std::string& name, int frames) const {
    VideoWriter writer(Study(name), kWidth, kHeight, 25);
    for (int i = 0; i < frames; ++i) writer.Write(ToImage(picture_));
    writer.Finish();
  }
  void WriteMotionJpeg(const std::string& name, int frames, double scale = 1.0) const {
    cv::Mat picture;
    cv::resize(picture_, picture, {}, scale, scale);
    cv::VideoWriter writer(Study(name), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                           25, picture.size(), true);
    for (int i = 0; i < frames; ++i) writer.write(picture);
  }
  static std::string Slurp(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void Spill(const std::string& name, const std::string& bytes) const {
    std::ofstream(Study(name), std::ios::binary) << bytes;
  }
  ReplayResult Run(
      ReplayRequest::InitialPose registration = ReplayRequest::InitialPose::Given) const {
    ReplayRequest request;
    request.registration = registration;
    request.study = folder_ / "study";
    request.results = folder_ / "results";
    request.tetrahedra = 300;
    request.drawing = ReplayRequest::Drawing::None;
    request.method.wanted_features = 60;
    Progress silent;
    return Replay(request, silent);
  }
  /// What the shell prints before it ends with exit status 3.
  std::string Refusal() const {
    try {
      Run();
    } catch (const InputError& error) {
      EXPECT_FALSE(fs::exists(folder_ / "results/case")) << "refused before the planning";
      return error.what();
    }
    return "";
  }

  Scratch folder_;
  CameraModel camera_ = testing::Pinhole(kWidth, kHeight, 300, Vec3(0, 0, 150));
  cv::Mat picture_;
};

TEST_F(ReplayVideo, AWholeVideoIsDone) {
  WriteH264("video.mp4", kFrames);
  const ReplayResult result = Run();
  EXPECT_EQ(result.frames, kFrames);
  EXPECT_FALSE(result.broken);
  EXPECT_EQ(result.final_gate, GateState::Green) << result.final_reason;
}

TEST_F(ReplayVideo, ImagesServeAsWell) {
  fs::create_directories(Study("frames"));
  for (int i = 0; i < kFrames; ++i)
    cv::imwrite(Study("frames/" + std::to_string(1000 + i) + ".png"), picture_);
  NameVideo("frames");
  EXPECT_EQ(Run().frames, kFrames);
  NameVideo("frames/%04d.png");
  EXPECT_EQ(Run().frames, kFrames);
}

TEST_F(ReplayVideo, EmptyIsRefused) {
  Spill("video.mp4", "");
  EXPECT_THAT(Refusal(), HasSubstr("video.mp4: frame 0"));
}

TEST_F(ReplayVideo, TruncatedIsRefused) {
  WriteH264("whole.mp4", kFrames);
  const std::string bytes = Slurp(Study("whole.mp4"));
  Spill("video.mp4", bytes.substr(0, bytes.size() / 2));  // the index is at the end
  EXPECT_THAT(Refusal(), HasSubstr("video.mp4"));
  EXPECT_THAT(Refusal(), HasSubstr("truncated"));
}

TEST_F(ReplayVideo, OneFrameIsRefused) {
  WriteH264("video.mp4", 1);
  EXPECT_THAT(Refusal(), HasSubstr("video.mp4: frame 1"));
}

TEST_F(ReplayVideo, AnotherSizeThanTheCamerasIsRefused) {
  WriteH264("video.mp4", 3);
  camera_.width = 320;
  WriteCameraFile(Study("camera.yml"), camera_);
  const std::string said = Refusal();
  EXPECT_THAT(said, HasSubstr("video.mp4: frame size"));
  EXPECT_THAT(said, HasSubstr("camera.yml"));
}

TEST_F(ReplayVideo, AChangeOfSizeEndsItAndKeepsWhatWasDone) {
  WriteMotionJpeg("a.mjpeg", 6);
  WriteMotionJpeg("b.mjpeg", 6, 0.5);
  Spill("both.mjpeg", Slurp(Study("a.mjpeg")) + Slurp(Study("b.mjpeg")));
  NameVideo("both.mjpeg");
  const ReplayResult result = Run();
  ASSERT_TRUE(result.broken);
  EXPECT_THAT(*result.broken, HasSubstr("both.mjpeg: frame 6: the size changes"));
  EXPECT_EQ(result.frames, 6);
  EXPECT_EQ(ReadReliabilityFile(Results("reliability.csv")).size(), 6u);
}

TEST_F(ReplayVideo, ABreakInTheMiddleKeepsWhatWasDoneAndSaysSo) {
  WriteMotionJpeg("whole.avi", kFrames);
  const std::string bytes = Slurp(Study("whole.avi"));
  Spill("cut.avi", bytes.substr(0, bytes.size() * 6 / 10));
  NameVideo("cut.avi");
  const ReplayResult result = Run();
  ASSERT_TRUE(result.broken);
  EXPECT_THAT(*result.broken, HasSubstr("cut.avi: breaks at frame"));
  EXPECT_GT(result.frames, 2);
  EXPECT_LT(result.frames, kFrames);
  EXPECT_EQ(ReadTimingFile(Results("timing.csv")).size(), std::size_t(result.frames));
  EXPECT_TRUE(fs::exists(Results("organ_final.vtu")));
  EXPECT_TRUE(fs::exists(Results(FrameFileName(result.frames - 1, "organ", "vtp"))))
      << "the last frame that could be read is written";
  EXPECT_THAT(Slurp(Results("journal.jsonl")), HasSubstr("source broken"));
  EXPECT_THAT(Slurp(Results("report.html")), HasSubstr("breaks at frame"));
}

TEST_F(ReplayVideo, LandmarksTellTheirResidualsAndTheWrongOneIsNamed) {
  WriteH264("video.mp4", 3);
  {
    std::ofstream file(Study("landmarks.csv"));
    file << "id,x_mm,y_mm,z_mm,u_px,v_px\n";
    int id = 10;
    for (const double x : {-30.0, 0.0, 30.0})
      for (const double y : {-15.0, 16.0}) {
        const Vec3 p(x, y, std::abs(x) > 1 ? -6 : 6);
        Vec2 pixel = camera_.Project(p);
        if (id == 13) pixel.x() += 25;
        file << id++ << ',' << -p.x() << ',' << -p.y() << ',' << p.z() << ',' << pixel.x() << ','
             << pixel.y() << '\n';
      }
  }
  const ReplayResult result = Run(ReplayRequest::InitialPose::Landmarks);
  ASSERT_EQ(result.landmarks.size(), 6u);
  for (const LandmarkFit& fit : result.landmarks) {
    EXPECT_EQ(fit.outlier, fit.id == 13);
    if (fit.id == 13)
      EXPECT_NEAR(fit.residual_px, 25, 2);
    else
      EXPECT_LT(fit.residual_px, 1.0);
  }
  EXPECT_THAT(Slurp(Results("journal.jsonl")), HasSubstr("\"outlier_ids\":[13"));
}

TEST_F(ReplayVideo, StagesAndTotalAgree) {
  WriteH264("video.mp4", kFrames);
  Run();
  for (const TimingRow& t : ReadTimingFile(Results("timing.csv")))
    EXPECT_NEAR(t.total_ms,
                t.capture_ms + t.tracking_ms + t.targets_ms + t.detection_ms + t.cutting_ms +
                    t.solve_ms + t.structures_ms + t.render_ms,
                0.01)
        << "frame " << t.frame;
}

}  // namespace
}  // namespace kerf
