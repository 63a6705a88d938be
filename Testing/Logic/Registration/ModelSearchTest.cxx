#include <gtest/gtest.h>

#include <numeric>
#include <thread>

#include "Cutting/Bridges.h"
#include "HeldBar.h"
#include "Registration/ModelProbe.h"
#include "Registration/ModelSearch.h"
#include "Registration/Step.h"

namespace kerf {
namespace {

using namespace held_bar;

std::optional<BetterModel> Probed(const Model& model) {
  return ProbeModel(model.usable, Above(), {}, {},
                    std::make_shared<const RegistrationState>(model.state));
}

class StandingTracker : public FeatureTracker {
 public:
  FeatureSet Detect(const Frame&, const Image&, int) override { return {}; }
  void Track(const Frame&, FeatureSet*) override {}
};

/// Counts the equilibria that it is asked for.
class Counted : public PassingSolver {
 public:
  Counted(std::unique_ptr<ElasticSolver> inner, int* solves)
      : PassingSolver(std::move(inner)), solves_(solves) {}
  SolveReport Solve(const Springs& springs, const Fixations& held, const SolveOptions& options,
                    Points* positions, Points* velocities) override {
    ++*solves_;
    return PassingSolver::Solve(springs, held, options, positions, velocities);
  }

 private:
  int* solves_;
};

/// A model whose cut is `cut` in front of what is seen of `truth`, and a search that has begun.
struct Searched {
  Model model;
  StandingTracker tracker;
  Solvers solvers;
  ModelSearch search;
  Engine engine{tracker, solvers, model.cutter, nullptr, nullptr, &search};
  int grip_solves = 0;

  Searched(const ModelCut& cut, const ModelCut& truth) : model(&cut) {
    model.Follow(Seen(Truth(&truth, 1.0)));
    RegistrationState& state = model.state;
    state.features.id.resize(model.usable.size());
    std::iota(state.features.id.begin(), state.features.id.end(), 0);
    state.features.status.assign(model.usable.size(), FeatureStatus::Tracked);
    state.velocities = Points::Zero(state.mesh.VertexCount(), 3);
    state.blind_outline.resize(0, 3);
    solvers.organ = MakeKerfSolver();
    solvers.organ->Reset(state.mesh, {});
    solvers.grips = std::make_unique<Counted>(std::move(model.solver), &grip_solves);
    EXPECT_TRUE(search.Begin(model.usable, Above(), {}, state));
    state.probing.due_frame = 8;
  }
  StepReport StepAt(int index, const MethodOptions& options = {}) {
    Frame frame;
    frame.index = index;
    return Step(frame, Above(), options, engine, &model.state);
  }
};

TEST(ModelSearch, WhatItFoundComesWithGripsOfItsOwn) {
  const ModelCut right = CutTo(4.0, 0), shorter = CutTo(-3.0, 0);
  Searched searched(shorter, right);
  EXPECT_TRUE(searched.StepAt(7).cuts.empty());
  EXPECT_GT(searched.grip_solves, 0);
  searched.grip_solves = 0;
  const StepReport report = searched.StepAt(8);
  ASSERT_EQ(report.cuts.size(), 1u);
  EXPECT_TRUE(report.cuts[0].report.done);
  EXPECT_LE(report.solve.steps, 1) << "a frame in which the organ is cut";
  EXPECT_LE(report.solve.cg_iterations, 16);
  EXPECT_EQ(searched.grip_solves, 0) << "those of before are not brought up to date first";
  const GripFit& grips = searched.model.state.grips;
  EXPECT_TRUE(grips.torn) << "nor are those that came";
  EXPECT_FALSE(SettlesOnly(grips)) << "the next frame corrects the motions";
  EXPECT_EQ(grips.positions.rows(), searched.model.state.mesh.VertexCount());
  const auto motion = grips.motions[0].matrix().eval();
  searched.StepAt(9);
  EXPECT_FALSE(grips.torn);
  EXPECT_FALSE(grips.motions[0].matrix() == motion);
}

TEST(ModelSearch, ALowerLimitHoldsWhereACutIsTakenOverToo) {
  const ModelCut right = CutTo(4.0, 0), shorter = CutTo(-3.0, 0);
  Searched searched(shorter, right);
  MethodOptions options;
  options.solve.most_iterations = 3;
  const StepReport report = searched.StepAt(8, options);
  ASSERT_EQ(report.cuts.size(), 1u);
  EXPECT_LE(report.solve.cg_iterations, 3);
}

TEST(ModelSearch, WithoutAnAnswerTheGripsAreBroughtUpToDateAsEver) {
  const ModelCut right = CutTo(4.0, 0), shorter = CutTo(-3.0, 0);
  Searched dropped(shorter, right), held(shorter, right);
  dropped.search.Drop();
  EXPECT_TRUE(dropped.StepAt(8).cuts.empty());
  EXPECT_GT(dropped.grip_solves, 0);
  MethodOptions options;
  options.hold_search = true;
  EXPECT_TRUE(held.StepAt(8, options).cuts.empty());
  EXPECT_GT(held.grip_solves, 0);
}

// A cut that has grown elsewhere meanwhile stays, and so do its grips: they go on.
TEST(ModelSearch, AnAnswerThatComesTooLateLeavesTheGripsToTheFrame) {
  const ModelCut right = CutTo(4.0, 0), shorter = CutTo(-3.0, 0);
  Searched searched(shorter, right);
  Points& line = searched.model.state.cuts[0].line.points;
  line.row(line.rows() - 1) += Eigen::RowVector3d(20.0, 0.0, 0.0);
  EXPECT_TRUE(searched.StepAt(8).cuts.empty());
  EXPECT_GT(searched.grip_solves, 0);
}

TEST(ModelSearch, BegunAgainWhereItGetsNoCoreItGivesTheSameAnswer) {
  const ModelCut right = CutTo(4.0, 0), shorter = CutTo(-3.0, 0);
  Model model(&shorter);
  model.Follow(Seen(Truth(&right, 1.0)));
  const auto state = std::make_shared<const RegistrationState>(model.state);
  const auto probe = [&](const std::atomic<bool>* given_up) {
    return ProbeModel(model.usable, Above(), {}, {}, state, given_up);
  };
  const auto direct = probe(nullptr);
  std::atomic<int> begun{0};
  const std::atomic<bool> given_up{false};
  const auto sleeper_first = [&](const std::atomic<bool>* left) -> std::optional<BetterModel> {
    if (begun++ > 0) return probe(left);
    while (!*left) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return std::nullopt;
  };
  const auto answer = ModelSearch::BehindOthers(sleeper_first, given_up);
  EXPECT_EQ(begun, 2);
  ASSERT_TRUE(direct && answer.better);
  EXPECT_TRUE(direct->fitted.positions == answer.better->fitted.positions);
  EXPECT_TRUE(answer.left_behind.valid());
}

TEST(ModelSearch, GivenUpItEndsWithoutAnAnswer) {
  const std::atomic<bool> given_up{true};
  const auto answer = ModelSearch::BehindOthers(
      [](const std::atomic<bool>* left) -> std::optional<BetterModel> {
        while (!*left) std::this_thread::sleep_for(std::chrono::milliseconds(5));
        return std::nullopt;
      },
      given_up);
  EXPECT_FALSE(answer.better);
}

TEST(ModelProbe, HeldPartsAreAsLongAsTheTracksSay) {
  const Pixels seen = Seen(Truth(nullptr, 1.0));
  Model right;
  right.Follow(seen);
  EXPECT_FALSE(Probed(right));
  Model model;
  model.state.grips = Regripped(model.state.grips, {0.6, 0.6});
  model.Follow(seen);
  const auto better = Probed(model);
  ASSERT_TRUE(better);
  EXPECT_EQ(better->by, BetterModel::By::Regripped);
  for (int end : {0, 1})
    EXPECT_LT(better->fitted.regions[end].from_mm, model.state.grips.regions[end].from_mm);
}

TEST(ModelProbe, ACutThatIsTooShortGrowsAtItsInnerEnd) {
  const ModelCut right = CutTo(4.0, 0), shorter = CutTo(-3.0, 0);
  Model model(&shorter);
  model.Follow(Seen(Truth(&right, 1.0)));
  EXPECT_TRUE(WorthProbing({}, {}, model.state));
  const auto better = Probed(model);
  ASSERT_TRUE(better);
  EXPECT_EQ(better->by, BetterModel::By::Longer);
  const Points& line = better->instead.line.points;
  EXPECT_GT(line.col(1).maxCoeff(), -1.0);
  EXPECT_NEAR(line.col(1).minCoeff(), -24.0, 1e-9);  // nothing at the end that is over the rim
}

TEST(ModelProbe, ACutThatIsTooLongIsTakenBack) {
  const ModelCut right = CutTo(-3.0, 0), longer = CutTo(6.0, 0);
  Model model(&longer);
  model.Follow(Seen(Truth(&right, 1.0)));
  const auto better = Probed(model);
  ASSERT_TRUE(better);
  EXPECT_EQ(better->by, BetterModel::By::Shorter);
  EXPECT_LT(better->instead.line.points.col(1).maxCoeff(), 4.0);
  EXPECT_EQ(better->model.mesh.VertexCount(), better->fitted.positions.rows());
}

TEST(ModelProbe, ACutThatIsRightStaysAsItIs) {
  const ModelCut right = CutTo(4.0, 0);
  Model model(&right);
  model.Follow(Seen(Truth(&right, 1.0)));
  EXPECT_FALSE(Probed(model));
  // What is left is less than directions are searched for.
  EXPECT_FALSE(WorthProbing({}, {}, model.state));
}

// The line drawn anew is right but too short: what is better is gone on from.
TEST(ModelProbe, ALineDrawnAnewIsMadeLongerAtOnce) {
  const ModelCut right = CutTo(4.0, 0), shorter = CutTo(-5.0, 0);
  ModelCut beside = shorter;
  beside.line.points.col(0).array() += 4.0;
  beside.surface = ExtrudeCut(beside.line, beside.direction, beside.depth_mm);
  beside.redrawn = shorter.line.points;
  Model model(&beside);
  model.Follow(Seen(Truth(&right, 1.0)));
  const auto better = Probed(model);
  ASSERT_TRUE(better);
  EXPECT_EQ(better->by, ModelChange::By::Redrawn);
  const Points& line = better->instead.line.points;
  EXPECT_LT((line.col(0) - right.line.points.col(0).head(1).replicate(line.rows(), 1))
                .cwiseAbs()
                .maxCoeff(),
            1e-6);
  EXPECT_GT(line.col(1).maxCoeff(), -3.0);
}

// The mesh was left joined by a thread of tissue in the middle of S: it is cut anew.
TEST(ModelProbe, AThreadAcrossACutIsCut) {
  const ModelCut right = CutTo(6.0, 0);
  ModelCut threaded = right;
  threaded.surface = testing::WithHole(right.surface, {3, -8, 0}, 4.0);
  Model model(&threaded);
  model.state.cuts[0].surface = right.surface;
  ASSERT_TRUE(JoinedAcross(model.state.mesh, right.surface));
  model.Follow(Seen(Truth(&right, 1.0)));
  const auto better = Probed(model);
  ASSERT_TRUE(better);
  EXPECT_FALSE(JoinedAcross(better->model.mesh, better->instead.surface));
  EXPECT_GT(better->instead.direction.dot(right.direction), 0.999);
  EXPECT_LT(better->fitted.cost_mm2, 0.5 * model.state.grips.cost_mm2);
}

TEST(ModelProbe, ACutInAWrongDirectionIsTurned) {
  const ModelCut right = CutTo(9.0, 24), straight = CutTo(9.0, 0);
  Model model(&straight);
  model.Follow(Seen(Truth(&right, 1.0)));
  model.state.probing.turn = true;
  const auto better = Probed(model);
  ASSERT_TRUE(better);
  EXPECT_EQ(better->by, BetterModel::By::Turned);
  EXPECT_GT(better->instead.direction.dot(right.direction),
            straight.direction.dot(right.direction));
}

}  // namespace
}  // namespace kerf
