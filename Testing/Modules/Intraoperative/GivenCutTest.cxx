// A cut that is given by hand opens in the model where the true one does in the picture: what the
// overlay draws as its lips, held against the true lips, both ways. No window is needed.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "Adapters/OpenCv/VideoSource.h"
#include "CaseIO/StudyFolder.h"
#include "DeskScene.h"
#include "Session/TableTracker.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using namespace testing;

/// A line of the truth (RAS), LPS.
Points Line(const nlohmann::json& list) {
  Points line(list.size(), 3);
  for (std::size_t i = 0; i < list.size(); ++i)
    line.row(i) << -list[i][0].get<double>(), -list[i][1].get<double>(), list[i][2].get<double>();
  return line;
}

/// Both lips of the truth in one line, over the tip that they end 1 mm before.
Points TrueEdge(const nlohmann::json& at) {
  const Points minus = Line(at["lip_minus"]), plus = Line(at["lip_plus"]);
  Points edge(minus.rows() + plus.rows(), 3);
  edge << minus, plus.colwise().reverse();
  return edge;
}

/// Points at least every third of a millimetre along lines, in the picture, px.
std::vector<Vec2> InPicture(const std::vector<Points>& lines, const CameraModel& camera) {
  std::vector<Vec2> out;
  for (const Points& line : lines)
    for (Index i = 0; i + 1 < line.rows(); ++i) {
      const Vec3 from = line.row(i).transpose(), to = line.row(i + 1).transpose();
      const int steps = 1 + static_cast<int>(3 * (to - from).norm());
      for (int k = 0; k <= steps; ++k)
        out.push_back(camera.Project(from + (to - from) * k / steps));
    }
  return out;
}

using Distances = std::vector<double>;

void AddDistances(const std::vector<Vec2>& points, const std::vector<Vec2>& line, Distances* out) {
  for (const Vec2& p : points) {
    double nearest = 1e9;
    for (const Vec2& q : line) nearest = std::min(nearest, (p - q).norm());
    out->push_back(nearest);
  }
}

double Share(Distances distances, double share) {
  std::sort(distances.begin(), distances.end());
  return distances[static_cast<std::size_t>(share * (distances.size() - 1))];
}

constexpr double kAim_px = 3.0;  // 0.6 mm

double Within_px(const Distances& distances, double most) {
  const auto near = [&](double d) { return d <= most; };
  return double(std::count_if(distances.begin(), distances.end(), near)) / double(distances.size());
}

/// The first pictures of a video.
class FirstPictures : public FrameSource {
 public:
  FirstPictures(const std::string& path, int count) : video_(OpenVideo(path)), count_(count) {}
  std::optional<Frame> Next() override { return next_++ < count_ ? video_->Next() : std::nullopt; }
  int Width() const override { return video_->Width(); }
  int Height() const override { return video_->Height(); }
  double FramesPerSecond() const override { return video_->FramesPerSecond(); }
  int FrameCount() const override { return count_; }

 private:
  std::unique_ptr<FrameSource> video_;
  int count_, next_ = 0;
};

/// The edge of the phantom's cut, given in its first frame, in the last of which the truth
/// is known: of meshes of 13,000,
/// 15,000 and 17,000 tetrahedra together, since where the mesh ends at the cut's tip is luck.
class GivenCut : public ::testing::Test {
 protected:
  void Run(const IntraoperativeDesk::TrackerMaker& tracker) {
    const std::string study = PhantomCase::Study();
    ASSERT_TRUE(fs::exists(study + "/video.mp4")) << "the fixture makes the phantom";
    const auto truth = nlohmann::json::parse(std::ifstream(study + "/truth/cuts.json"))["cuts"][0];
    const auto& end = truth["evaluated"].back();
    for (const int tetrahedra : {13000, 15000, 17000}) {
      const PhantomCase phantom(tetrahedra);
      IntraoperativeDesk desk;
      desk.SetTrackerMaker(tracker);
      phantom.OpenFor(&desk, [&](const std::string& path) {
        return std::make_unique<FirstPictures>(path, end["frame"].get<int>() + 1);
      });
      desk.BeginExposure();
      IntraoperativeDecision given;
      given.kind = IntraoperativeDecision::Kind::DrawCut;
      given.line = Line(truth["polyline_rest"]);
      desk.GiveCuts({given});
      IntraoperativeDesk::RunOptions run;
      run.hold_cuts = true;  // the given cut alone
      run.record = false;
      run.deadline_ms = 0;  // the same figures on every machine
      desk.Accept(run);
      ASSERT_TRUE(Within(200, [&] {
        const SourceState source = desk.Source();
        return source.kind == SourceState::Kind::Ended && desk.Latest() &&
               desk.Latest()->frame.index + 1 == source.delivered;
      }));
      const auto latest = desk.Latest();
      ASSERT_EQ(latest->frame.index, end["frame"].get<int>());
      ASSERT_FALSE(latest->applied_lines.empty());
      const auto drawn = InPicture(latest->applied_lines, desk.Camera());
      const auto is = InPicture({TrueEdge(end)}, desk.Camera());
      Distances from_model, from_truth;
      AddDistances(drawn, is, &from_model);
      AddDistances(is, drawn, &from_truth);
      std::printf("%d tetrahedra\n", tetrahedra);
      Print(from_model, from_truth);
      from_model_.insert(from_model_.end(), from_model.begin(), from_model.end());
      from_truth_.insert(from_truth_.end(), from_truth.begin(), from_truth.end());
    }
    std::printf("all\n");
    Print(from_model_, from_truth_);
  }
  static void Print(const Distances& from_model, const Distances& from_truth) {
    for (const auto& [name, d] :
         {std::pair("model to truth", &from_model), std::pair("truth to model", &from_truth)})
      std::printf(
          "%s: median %.1f px, 90 %% within %.1f px, all within %.1f px; within %.0f px %.0f %%\n",
          name, Share(*d, 0.5), Share(*d, 0.9), Share(*d, 1.0), kAim_px,
          100 * Within_px(*d, kAim_px));
  }
  Distances from_model_, from_truth_;  ///< px
};

// Three quarters of the edge and more keep the aim; docs/validation.md says what was measured and
// what the rest is. A line that is led on by itself shows in the largest distance.

TEST_F(GivenCut, OpensWhereTheTrueOneDoesByGivenTracks) {
  const std::string study = PhantomCase::Study();
  ASSERT_NO_FATAL_FAILURE(Run([&] {
    return std::make_unique<TableTracker>(
        ReadTracks(study + "/features_2d.csv", study + "/features_rest.csv"));
  }));
  for (const Distances* d : {&from_model_, &from_truth_}) {
    EXPECT_LT(Share(*d, 0.5), 1.1);
    EXPECT_LT(Share(*d, 0.9), 4.2);
    EXPECT_LT(Share(*d, 1.0), 11.0);
    EXPECT_GT(Within_px(*d, kAim_px), 0.8);
  }
}

TEST_F(GivenCut, OpensWhereTheTrueOneDoesInTheVideo) {
  ASSERT_NO_FATAL_FAILURE(Run(nullptr));
  for (const Distances* d : {&from_model_, &from_truth_}) {
    EXPECT_LT(Share(*d, 0.5), 1.6);
    EXPECT_LT(Share(*d, 0.9), 7.0);
    EXPECT_LT(Share(*d, 1.0), 14.0);
    EXPECT_GT(Within_px(*d, kAim_px), 0.7);
  }
}

}  // namespace
}  // namespace kerf
