#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "Registration/GripFit.h"
#include "Registration/ModelUpdate.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf::held_bar {

// A bar of 100 × 36 × 24 mm seen from above, held at both ends, moved by a simulation of its own:
// the grips of the truth are the outer 14 mm, their motions known.
inline constexpr double kLength = 100, kWidth = 36, kHeight = 24;

inline CameraModel Above() { return testing::PinholeAbove(960, 540, 900, 250); }

inline TetMesh Bar() { return testing::BoxMesh({kLength, kWidth, kHeight}, 20, 8, 5); }

inline Points TopFeatures() {
  std::vector<Vec3> rest;
  for (double y = -15; y <= 15; y += 5)
    for (double x = -45; x <= 45; x += 6)
      rest.push_back({x + std::sin(5 * x + y), y + std::cos(3 * y + x), 0.5 * kHeight});
  Points rows(rest.size(), 3);
  for (std::size_t i = 0; i < rest.size(); ++i) rows.row(i) = rest[i].transpose();
  return rows;
}

/// Motions of the ends: apart, towards the camera on one side, turned.
inline Eigen::Isometry3d Motion(int end, double s) {
  const double sign = end == 0 ? 1.0 : -1.0;
  const Vec3 center(sign * 43, 0, 0);
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = Eigen::AngleAxisd(sign * 0.12 * s, Vec3::UnitY()).toRotationMatrix();
  motion.translation() =
      center + Vec3(sign * 4.0, 1.0, end == 0 ? 7.0 : 2.0) * s - motion.linear() * center;
  return motion;
}

/// The bar's S: across from the edge y = −18 to `to_y`, at x = 3, turned by `tilt_deg` about its
/// line.
inline ModelCut CutTo(double to_y, double tilt_deg) {
  ModelCut cut;
  cut.in_model = true;
  cut.line.points.resize(8, 3);
  for (int i = 0; i < 8; ++i)
    cut.line.points.row(i) << 3.0, -24.0 + (to_y + 24.0) * i / 7.0, 0.5 * kHeight;
  const double tilt = tilt_deg * M_PI / 180;
  cut.direction = Vec3(std::sin(tilt), 0, -std::cos(tilt));
  cut.view = Vec3(0, 0, -1);
  cut.depth_mm = 40;
  cut.surface = ExtrudeCut(cut.line, cut.direction, cut.depth_mm);
  return cut;
}

/// What the camera sees of a bar that is cut along `cut` (none: whole) and moved by s.
inline Points Truth(const ModelCut* cut, double s) {
  TetMesh mesh = Bar();
  BoundFeatures bound = BindingSurface(mesh, mesh.rest).Bind(Pixels(0, 2), Above());
  const CameraModel camera = Above();
  const Points rest = TopFeatures();
  Pixels pixels(rest.rows(), 2);
  for (Index i = 0; i < rest.rows(); ++i)
    pixels.row(i) = camera.Project(rest.row(i).transpose()).transpose();
  bound = BindingSurface(mesh, mesh.rest).Bind(pixels, camera);
  Embedding at = bound.embedding;
  if (cut) {
    const TopologyChange change = TetCutter().Cut(mesh, cut->surface);
    EXPECT_TRUE(change.changed);
    at = change.MapEmbedding(at, mesh);
    mesh = change.mesh;
  }
  const auto solver = MakeKerfSolver();
  solver->Reset(mesh, {});
  Fixations held;
  std::vector<Vec3> targets;
  Points positions = mesh.rest, velocities = Points::Zero(mesh.VertexCount(), 3);
  held.stiffness_g_s2 = 3e6;
  SolveOptions options;
  options.tolerance = 1e-6;
  Springs none;
  none.at.weights.resize(0, 4);
  for (int step = 1; step <= 5; ++step) {
    held.vertices.clear();
    targets.clear();
    for (Index v = 0; v < mesh.VertexCount(); ++v)
      for (int end = 0; end < 2; ++end)
        if ((end == 0 ? 1 : -1) * mesh.rest(v, 0) > 0.5 * kLength - 14.1) {
          held.vertices.push_back(v);
          targets.push_back(Motion(end, s * step / 5.0) * Vec3(mesh.rest.row(v).transpose()));
        }
    held.targets.resize(targets.size(), 3);
    for (std::size_t k = 0; k < targets.size(); ++k) held.targets.row(k) = targets[k].transpose();
    solver->Solve(none, held, options, &positions, &velocities);
  }
  return at.Positions(positions, mesh.tets);
}

inline Pixels Seen(const Points& world) {
  const CameraModel camera = Above();
  Pixels pixels(world.rows(), 2);
  for (Index i = 0; i < world.rows(); ++i)
    pixels.row(i) = camera.Project(world.row(i).transpose()).transpose();
  return pixels;
}

struct Model {
  RegistrationState state;
  std::unique_ptr<ElasticSolver> solver = MakeKerfSolver();
  std::vector<char> usable;
  TetCutter cutter;

  explicit Model(const ModelCut* cut = nullptr) {
    state.mesh = Bar();
    state.features.pixels = Seen(TopFeatures());
    state.bound = BindingSurface(state.mesh, state.mesh.rest).Bind(state.features.pixels, Above());
    state.origin =
        std::make_shared<const UncutModel>(UncutModel{state.mesh, state.bound.embedding, {}});
    state.uncut = std::make_shared<SurfaceTree>(BoundarySurface(state.mesh, state.mesh.rest));
    if (cut) {
      const TopologyChange change = cutter.Cut(state.mesh, cut->surface);
      EXPECT_TRUE(change.changed);
      state.bound.embedding = change.MapEmbedding(state.bound.embedding, state.mesh);
      state.mesh = change.mesh;
      state.cuts.push_back(*cut);
    }
    state.positions = state.mesh.rest;
    usable.assign(state.features.pixels.rows(), 1);
    state.grips = BeginGrips(state.mesh, state.bound, {}, {}, solver.get());
  }
  /// Follows a motion from rest to what is seen at the end, frame by frame.
  void Follow(const Pixels& seen, int frames = 40) {
    const Pixels rest = Seen(TopFeatures());
    for (int f = 1; f <= frames + 10; ++f) {
      state.features.pixels = rest + std::min(1.0, double(f) / frames) * (seen - rest);
      UpdateGrips(state.mesh, {}, state.bound, state.features.pixels, usable, Above(), {},
                  solver.get(), &state.grips);
    }
    state.positions = state.grips.positions;
  }
  double MeanError_mm(const Points& truth) const {
    return (state.bound.embedding.Positions(state.grips.positions, state.mesh.tets) - truth)
        .rowwise()
        .norm()
        .mean();
  }
};

/// A solver that another one works for; tests look at what is asked and answered.
class PassingSolver : public ElasticSolver {
 public:
  explicit PassingSolver(std::unique_ptr<ElasticSolver> inner) : inner_(std::move(inner)) {}
  void Reset(const TetMesh& mesh, const Material& material) override {
    inner_->Reset(mesh, material);
  }
  void Apply(const TopologyChange& change) override { inner_->Apply(change); }
  SolveReport Solve(const Springs& springs, const Fixations& held, const SolveOptions& options,
                    Points* positions, Points* velocities) override {
    return inner_->Solve(springs, held, options, positions, velocities);
  }

 private:
  std::unique_ptr<ElasticSolver> inner_;
};

}  // namespace kerf::held_bar
