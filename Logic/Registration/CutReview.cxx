#include "Registration/CutReview.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "Geometry/EmbedPoints.h"
#include "Registration/CutLine.h"
#include "Registration/ModelUpdate.h"
#include "Registration/Untangle.h"

namespace kerf {
namespace {

constexpr double kShortest_mm = 1.0;   // points of a stroke that are nearer than this are merged
constexpr double kRefusedReach = 2.5;  // in feature spacings: pairs this near to a refused line
constexpr double kBehind_mm = 500.0;   // rays start well in front of the organ
constexpr double kOver_mm = 6.0;       // how far a line that goes over the rim reaches beyond it
constexpr double kThinStrip_mm = 5.0;  // what is left on purpose is wider, in any mesh
constexpr double kProbe_mm = 0.5;      // steps in which the rim is looked for
constexpr double kAim_mm = 4.0;  // the last millimetres of a stroke give the direction it ends in

/// Edge of the regular tetrahedron that is as large as the mean one.
double ElementSize_mm(const TetMesh& mesh) {
  double volume = 0.0;
  for (Index t = 0; t < mesh.TetCount(); ++t) volume += TetVolume(mesh.rest, mesh.tets, t);
  return std::cbrt(6.0 * std::sqrt(2.0) * volume / std::max<Index>(1, mesh.TetCount()));
}

/// `line` with each end that stops less than `reach_mm` before the organ's rim, seen along `view`,
/// led over it: the strip that would be left is thinner than an element.
Points LedOverRim(Points line, const Vec3& view, const SurfaceTree& uncut, double reach_mm) {
  for (const bool at_end : {false, true}) {
    const Index last = static_cast<Index>(line.rows()) - 1;
    const Vec3 end = line.row(at_end ? last : 0).transpose();
    const Points shorter = Shortened(line, at_end, kAim_mm);
    Vec3 inner = line.row(at_end ? 0 : last).transpose();
    if (shorter.rows() > 0) inner = shorter.row(at_end ? shorter.rows() - 1 : 0).transpose();
    Vec3 outwards = end - inner;
    outwards -= view * view.dot(outwards);
    if (!(outwards.norm() > 1e-9)) continue;
    outwards.normalize();
    const auto over_organ = [&](double d) {
      return uncut.IsHit({end + d * outwards - kBehind_mm * view, view});
    };
    // The rim, from where the line is inside it: it may already reach a little over it.
    double rim = -kOver_mm;
    if (!over_organ(rim)) continue;
    while (rim <= reach_mm && over_organ(rim)) rim += kProbe_mm;
    if (rim <= reach_mm) line = LedOn(line, at_end, end + (rim + kOver_mm) * outwards);
  }
  return line;
}

}  // namespace

void RestoreModel(const RegistrationState& before, const MethodOptions& options, Engine& engine,
                  RegistrationState* state) {
  RegistrationState restored = before;
  restored.frame = state->frame;
  restored.features = std::move(state->features);
  restored.neighbors = std::move(state->neighbors);
  restored.evidence = std::move(state->evidence);
  restored.cuts = std::move(state->cuts);
  // The organ has moved since: every vertex goes on from where its material is now. Springs that
  // forget far targets would not bring it there from the positions of then.
  const Embedding at = EmbedPoints(state->mesh, restored.mesh.rest);
  restored.positions = at.Positions(state->positions, state->mesh.tets);
  restored.velocities.setZero();
  restored.probing = {};
  Untangle(restored.mesh, &restored.positions);
  if (state->grips.positions.rows() == state->mesh.VertexCount()) {
    restored.grips = state->grips;
    restored.grips.positions = at.Positions(state->grips.positions, state->mesh.tets);
    restored.grips.fields.clear();
    restored.grips.settled = false;
    Untangle(restored.mesh, &restored.grips.positions);
  }
  *state = std::move(restored);
  engine.cutter = TetCutter();
  engine.solvers.organ->Reset(state->mesh, options.material);
  if (engine.solvers.grips) engine.solvers.grips->Reset(state->mesh, options.material);
}

void RefuseEvidence(const Points& line, RegistrationState* state) {
  CutEvidence& evidence = state->evidence;
  const FeatureTriangulation& t = evidence.triangulation;
  if (t.Empty() || line.rows() < 2) return;
  const Index edges = static_cast<Index>(t.edges.size());
  if (evidence.refused_mm.size() != edges) evidence.refused_mm = Eigen::VectorXd::Zero(edges);
  if (evidence.last_mm.size() != edges) evidence.last_mm = Eigen::VectorXd::Zero(edges);
  std::vector<Index> near;
  double largest = 0.0;
  for (Index e = 0; e < edges; ++e) {
    const auto [l, m] = t.edges[e];
    const Vec3 middle = 0.5 * (state->bound.rest.row(l) + state->bound.rest.row(m)).transpose();
    if (DistanceToLine(line, middle) > kRefusedReach * t.spacing_mm) continue;
    near.push_back(e);
    largest = std::max(largest, evidence.last_mm[e]);
  }
  for (Index e : near) {
    evidence.refused_mm[e] = std::max(evidence.refused_mm[e], largest);
    evidence.streak[e] = 0;
  }
}

Points RestLineOfStroke(const Pixels& pixels, const CameraModel& camera,
                        const RegistrationState& state) {
  std::vector<Index> vertex;
  const SurfaceMesh current = BoundarySurface(state.mesh, state.positions, &vertex);
  const SurfaceTree tree(current);
  struct Place {
    std::optional<Vec3> rest;
    Vec3 now = Vec3::Zero();
    double depth_mm = 0.0;
  };
  std::vector<Place> places(pixels.rows());
  int hits = 0;
  for (Index i = 0; i < pixels.rows(); ++i) {
    const auto hit = tree.FirstHit(camera.RayThrough(pixels.row(i).transpose()));
    if (!hit) continue;
    Vec3 rest = Vec3::Zero();
    for (int k = 0; k < 3; ++k)
      rest += hit->weights[k] *
              state.mesh.rest.row(vertex[current.triangles(hit->triangle, k)]).transpose();
    places[i] = {rest, hit->point, camera.Depth(hit->point)};
    ++hits;
  }
  if (hits < 2) return Points(0, 3);
  const auto nearest_hit = [&](Index i) {
    for (Index d = 1; d < pixels.rows(); ++d) {
      if (i - d >= 0 && places[i - d].rest) return i - d;
      if (i + d < pixels.rows() && places[i + d].rest) return i + d;
    }
    return i;
  };
  std::vector<Vec3> line;
  for (Index i = 0; i < pixels.rows(); ++i) {
    Vec3 p;
    if (places[i].rest) {
      p = *places[i].rest;
    } else {  // beside the organ: as far from the nearest place on it as it is in the image
      const Place& by = places[nearest_hit(i)];
      p = *by.rest + camera.PointAtDepth(pixels.row(i).transpose(), by.depth_mm) - by.now;
    }
    if (line.empty() || (p - line.back()).norm() >= kShortest_mm) line.push_back(p);
  }
  if (line.size() < 2) return Points(0, 3);
  Points out(line.size(), 3);
  for (std::size_t i = 0; i < line.size(); ++i) out.row(i) = line[i].transpose();
  return out;
}

ModelCut MakeDrawnCut(const Points& line, const Vec3& direction, double depth_mm,
                      const RegistrationState& state) {
  ModelCut cut;
  cut.direction = cut.view = direction.normalized();
  cut.line.points =
      LedOverRim(line, cut.view, *state.uncut, std::min(ElementSize_mm(state.mesh), kThinStrip_mm));
  cut.depth_mm = depth_mm;
  cut.surface = ExtrudeCut(cut.line, cut.direction, depth_mm);
  cut.detected_frame = state.frame;
  cut.confidence = 1.0;
  cut.drawn = true;
  // What the features say of a cut's end is as fine as they lie apart: from a drawn end on it is
  // followed a spacing behind, but over the organ's rim.
  cut.too_far_mm.fill(state.evidence.triangulation.spacing_mm);
  return cut;
}

}  // namespace kerf
