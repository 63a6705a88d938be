// A cut that is given by hand opens in the model where the true one does in the picture: what the
// overlay draws as its lips, held against the true lips. No window is needed.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "DeskScene.h"
#include "Registration/CutLine.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using namespace testing;
using namespace std::chrono_literals;

/// A line of the truth (RAS), LPS.
Points Line(const nlohmann::json& list) {
  Points line(list.size(), 3);
  for (std::size_t i = 0; i < list.size(); ++i)
    line.row(i) << -list[i][0].get<double>(), -list[i][1].get<double>(), list[i][2].get<double>();
  return line;
}

double DistanceTo_px(const Points& line, const CameraModel& camera, const Vec2& p) {
  Points in_picture = Points::Zero(line.rows(), 3);
  for (Index i = 0; i < line.rows(); ++i)
    in_picture.row(i).head<2>() = camera.Project(line.row(i).transpose()).transpose();
  return DistanceToLine(in_picture, Vec3(p.x(), p.y(), 0));
}

TEST(GivenCut, OpensWhereTheTrueOneDoes) {
  const std::string study = KERF_TEST_PHANTOM;
  ASSERT_TRUE(fs::exists(study + "/video.mp4")) << "the fixture makes the phantom";
  const PhantomCase phantom(8000);
  const auto truth = nlohmann::json::parse(std::ifstream(study + "/truth/cuts.json"))["cuts"][0];
  const auto& end = truth["evaluated"].back();
  {
    IntraoperativeDesk desk;
    phantom.OpenFor(&desk);
    desk.BeginExposure();
    IntraoperativeDesk::RunOptions run;
    run.hold_cuts = true;  // the given cut alone
    run.record = false;
    desk.Accept(run);
    ASSERT_TRUE(Within(10, [&] { return desk.Latest() != nullptr; }));
    IntraoperativeDecision given;
    given.kind = IntraoperativeDecision::Kind::DrawCut;
    given.line = Line(truth["polyline_rest"]);
    desk.Post(given);
    ASSERT_TRUE(Within(200, [&] {
      return desk.Latest()->source.kind == SourceState::Kind::Ended &&
             desk.Latest()->frame.index >= end["frame"].get<int>();
    }));
    std::this_thread::sleep_for(300ms);
    const auto latest = desk.Latest();
    ASSERT_FALSE(latest->applied_lines.empty());
    std::vector<double> distances;
    for (const Points& lip : latest->applied_lines)
      for (Index i = 0; i + 1 < lip.rows(); ++i)
        for (const double t : {0.125, 0.375, 0.625, 0.875}) {
          const Vec2 p =
              desk.Camera().Project(((1.0 - t) * lip.row(i) + t * lip.row(i + 1)).transpose());
          distances.push_back(std::min(DistanceTo_px(Line(end["lip_minus"]), desk.Camera(), p),
                                       DistanceTo_px(Line(end["lip_plus"]), desk.Camera(), p)));
        }
    std::sort(distances.begin(), distances.end());
    const double median = distances[distances.size() / 2];
    RecordProperty("median_px", std::to_string(median));
    std::printf("lips of the given cut: median %.2f px, 90 %% within %.2f px of the true lips\n",
                median, distances[distances.size() * 9 / 10]);
    // 3 px (0.6 mm) is the aim; 0.7 to 2.9 px were measured with 7,000 to 9,000 tetrahedra.
    EXPECT_LT(median, 4.0);
  }
}

}  // namespace
}  // namespace kerf
