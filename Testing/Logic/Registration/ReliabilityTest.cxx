#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "Registration/CutEvidence.h"
#include "Registration/OrganMask.h"
#include "Registration/Reliability.h"
#include "Registration/Silhouette.h"
#include "Registration/Step.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

/// A block of 80 × 40 mm seen from 150 mm, features 4 mm apart, all where the model has them.
class ReliabilityTest : public ::testing::Test {
 protected:
  ReliabilityTest() {
    state_.mesh = testing::BoxMesh(Vec3(80, 40, 12), 12, 6, 2);
    state_.positions = state_.mesh.rest;
    std::vector<Vec2> pixels;
    for (double y = -18; y <= 18; y += 4)
      for (double x = -38; x <= 38; x += 4) pixels.push_back(camera_.Project(Vec3(x, y, -6)));
    const Index n = static_cast<Index>(pixels.size());
    state_.features.pixels.resize(n, 2);
    for (Index i = 0; i < n; ++i) {
      state_.features.id.push_back(i);
      state_.features.pixels.row(i) = pixels[i].transpose();
    }
    state_.features.status.assign(n, FeatureStatus::Tracked);
    state_.bound =
        BindingSurface(state_.mesh, state_.positions).Bind(state_.features.pixels, camera_);
    Points at_rest = state_.bound.rest;
    at_rest.col(2).array() += 150;
    state_.evidence = BeginEvidence(at_rest, state_.bound.on_surface);
  }
  Reliability Assess(const StepReport* step = nullptr) const {
    return AssessReliability(state_, camera_, state_.features.Size(), step);
  }
  Vec3 Rest(Index i) const { return state_.bound.rest.row(i).transpose(); }
  void Lose(const std::function<bool(const Vec3&)>& which) {
    for (Index i = 0; i < state_.features.Size(); ++i)
      if (which(Rest(i))) state_.features.status[i] = FeatureStatus::Lost;
  }
  /// Features seen elsewhere than the model has them. @return mean of how far, mm
  double Displace(const std::function<Vec3(const Vec3&)>& by_mm) {
    double sum_mm = 0.0;
    for (Index i = 0; i < state_.features.Size(); ++i) {
      const Vec3 by = by_mm(Rest(i));
      state_.features.pixels.row(i) = camera_.Project(Rest(i) + by).transpose();
      sum_mm += by.norm();
    }
    return sum_mm / double(state_.features.Size());
  }
  void Shift(const std::function<double(const Vec3&)>& by_mm) {
    Displace([&](const Vec3& p) -> Vec3 { return by_mm(p) * Vec3::UnitX(); });
  }
  /// `form` scaled to this mean; across the line of sight of the middle.
  void DisplaceByMean(const std::function<Vec3(const Vec3&)>& form, double mean_mm) {
    const double mean = Displace(form);
    Displace([&](const Vec3& p) -> Vec3 { return mean_mm / mean * form(p); });
  }
  /// What a step reports where the picture has the organ's outline elsewhere than the model.
  StepReport OutlineSeenAt(const Vec3& shift_mm) const {
    SurfaceMesh surface = BoundarySurface(state_.mesh, state_.positions);
    const Image model = ProjectedMask(surface, camera_);
    surface.points.rowwise() += shift_mm.transpose();
    const SilhouetteTargets seen =
        FindSilhouette(MakeBoundaryTopology(state_.mesh, {}), state_.mesh, state_.positions,
                       camera_, model, ProjectedMask(surface, camera_), 40);
    const double px_mm = camera_.Depth(Vec3(0, 0, -6)) / camera_.fx;
    StepReport report;
    report.outline_points = static_cast<int>(seen.at.Size());
    report.outline_off = (seen.off_px.array() * px_mm > kOutlineOff_mm).cast<double>().mean();
    return report;
  }
  CameraModel camera_ = testing::Pinhole(640, 480, 700, Vec3(0, 0, 150));
  RegistrationState state_;
};

TEST_F(ReliabilityTest, GreenWhereAllAgree) {
  const Reliability r = Assess();
  EXPECT_EQ(r.state, GateState::Green);
  EXPECT_EQ(r.reason, "ok");
  EXPECT_NEAR(r.score, 1.0, 1e-9);
  EXPECT_TRUE(std::isnan(r.tumour_u95_mm)) << "there is no tumour";
}

TEST_F(ReliabilityTest, FeaturesLostHereAndThereAreNoHarm) {
  int k = 0;
  Lose([&](const Vec3&) { return ++k % 3 == 0; });
  EXPECT_EQ(Assess().state, GateState::Green);
}

TEST_F(ReliabilityTest, AWrongFeatureIsNoHarm) {
  Shift([](const Vec3& p) { return (p - Vec3(2, 2, -6)).norm() < 2 ? 20.0 : 0.0; });
  EXPECT_EQ(Assess().state, GateState::Green);
}

TEST_F(ReliabilityTest, ALostRegionIsSaid) {
  Lose([](const Vec3& p) { return p.x() > 4; });
  const Reliability r = Assess();
  EXPECT_NE(r.state, GateState::Green);
  EXPECT_NE(r.reason.find("part of the organ"), std::string::npos) << r.reason;
}

TEST_F(ReliabilityTest, ACutThatTheModelDoesNotHaveIsSaid) {
  // The lips part by 12 mm; an uncut model stretches instead and lies between.
  Shift([](const Vec3& p) { return std::copysign(6.0 * std::exp(-std::abs(p.x()) / 15), p.x()); });
  const Reliability r = Assess();
  EXPECT_NE(r.state, GateState::Green);
  EXPECT_NE(r.reason.find("cut"), std::string::npos) << r.reason;
  EXPECT_GT(r.local_misfit_mm, 3.0);
}

TEST_F(ReliabilityTest, OffWhereNothingFits) {
  Shift([](const Vec3&) { return 8.0; });
  EXPECT_EQ(Assess().state, GateState::Off);
  Lose([](const Vec3&) { return true; });
  const Reliability r = Assess();
  EXPECT_EQ(r.state, GateState::Off);
  EXPECT_EQ(r.reason, "no feature is tracked");
}

/// The bounds that are promised: green in frames below 2 mm, off in frames over 5 mm.
TEST_F(ReliabilityTest, GreenBelow2mmAndOffOver5mmInEveryDirection) {
  for (int angle_deg = 0; angle_deg < 360; angle_deg += 30) {
    const double a = angle_deg * M_PI / 180;
    const Vec3 direction(std::cos(a), std::sin(a), 0);
    double score = 1.0;
    for (int tenth = 0; tenth <= 90; ++tenth) {
      const double by_mm = 0.1 * tenth;
      Displace([&](const Vec3&) -> Vec3 { return by_mm * direction; });
      const StepReport step = OutlineSeenAt(by_mm * direction);
      const Reliability r = Assess(&step);
      if (tenth < 20) {
        EXPECT_EQ(r.state, GateState::Green) << by_mm << " mm: " << r.reason;
      }
      if (tenth > 50) {
        EXPECT_EQ(r.state, GateState::Off) << by_mm << " mm, " << angle_deg;
      }
      EXPECT_NEAR(r.residual_mm, by_mm, 0.02);
      EXPECT_LE(r.score, score + 1e-6) << by_mm << " mm: more wrong and trusted more";
      score = r.score;
    }
    EXPECT_NEAR(score, 0.0, 1e-9);
  }
}

/// By the outline alone, with features that agree. What of it lies along a shift does not tell.
TEST_F(ReliabilityTest, AnOutlineThatIsOffBelow2mmIsGreenAndOver5mmIsSaid) {
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0.6, 0.8, 0)}) {
    const StepReport near = OutlineSeenAt(1.9 * direction), far = OutlineSeenAt(5.1 * direction);
    ASSERT_GE(std::min(near.outline_points, far.outline_points), 20) << "fewer say nothing";
    EXPECT_NEAR(Assess(&near).score, 1.0, 1e-9);
    EXPECT_LT(Assess(&far).score, 0.9);
    EXPECT_EQ(Assess(&far).state == GateState::Amber, far.outline_off > 0.5);
    EXPECT_EQ(far.outline_off > 0.5, std::abs(direction.y()) > 0.5) << "the long sides lie along x";
    if (far.outline_off > 0.5) {
      EXPECT_NE(Assess(&far).reason.find("outline"), std::string::npos);
    }
  }
}

/// Neither a shift: bent, turned about the sight, at a wrong distance. Mean over 5 mm is off, and
/// green stays what is nowhere over 2 mm.
TEST_F(ReliabilityTest, TheBoundsHoldForABendATurnAndAWrongSize) {
  const std::pair<const char*, std::function<Vec3(const Vec3&)>> forms[] = {
      {"bend", [](const Vec3& p) { return Vec3(0, p.x() * p.x(), 0); }},
      {"turn", [](const Vec3& p) { return Vec3(-p.y(), p.x(), 0); }},
      {"size", [](const Vec3& p) { return Vec3(p.x(), p.y(), 0); }},
      {"shear", [](const Vec3& p) { return Vec3(0, p.x(), 0); }}};
  for (const auto& [name, form] : forms) {
    DisplaceByMean(form, 5.1);
    EXPECT_EQ(Assess().state, GateState::Off) << name;
    double largest = 0.0;
    for (Index i = 0; i < state_.features.Size(); ++i)
      largest = std::max(largest, form(Rest(i)).norm());
    const double scale = 1.9 / largest;
    Displace([&, &form = form](const Vec3& p) -> Vec3 { return scale * form(p); });
    EXPECT_EQ(Assess().state, GateState::Green) << name << ": " << Assess().reason;
  }
}

/// A patch of a dozen features, wherever it lies, amid others that fit: no mean shows it.
TEST_F(ReliabilityTest, APatchThatIsOffBy5mmIsNotGreen) {
  for (const Vec3& middle : {Vec3(0, 0, -6), Vec3(22, 6, -6), Vec3(-34, 14, -6), Vec3(36, 0, -6)})
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-0.6, 0.8, 0)}) {
      const auto shift = [&](double by_mm) {
        return Displace([&](const Vec3& p) -> Vec3 {
          return (p - middle).norm() < 9.0 ? Vec3(by_mm * direction) : Vec3::Zero();
        });
      };
      EXPECT_LT(shift(5.1), 1.0);
      const Reliability r = Assess();
      EXPECT_EQ(r.state, GateState::Amber) << middle.transpose();
      EXPECT_NE(r.reason.find("part of the organ does not fit"), std::string::npos) << r.reason;
      shift(1.9);
      EXPECT_EQ(Assess().state, GateState::Green) << middle.transpose();
    }
}

/// Half of the organ fits, so the rest still helps: amber, however far the other half is off.
TEST_F(ReliabilityTest, AHalfThatIsOffIsNotGreen) {
  for (const double by_mm : {5.1, 8.0, 20.0}) {
    Shift([&](const Vec3& p) { return p.x() > 1.0 ? by_mm : 0.0; });
    EXPECT_NE(Assess().state, GateState::Green) << by_mm;
  }
}

TEST_F(ReliabilityTest, AnOutlineElsewhereIsSaid) {
  StepReport step;
  step.outline_points = 80;
  step.outline_off = 0.1;
  EXPECT_EQ(Assess(&step).state, GateState::Green);
  step.outline_off = 0.7;
  const Reliability r = Assess(&step);
  EXPECT_NE(r.state, GateState::Green);
  EXPECT_NE(r.reason.find("outline"), std::string::npos) << r.reason;
}

}  // namespace
}  // namespace kerf
