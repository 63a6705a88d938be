#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "Registration/CutEvidence.h"
#include "Registration/Reliability.h"
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
  /// Features seen elsewhere than the model has them.
  void Shift(const std::function<double(const Vec3&)>& by_mm) {
    for (Index i = 0; i < state_.features.Size(); ++i)
      state_.features.pixels.row(i) =
          camera_.Project(Rest(i) + by_mm(Rest(i)) * Vec3::UnitX()).transpose();
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
