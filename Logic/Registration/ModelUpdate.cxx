#include "Registration/ModelUpdate.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>

#include "Cutting/ExtrudePolyline.h"
#include "Geometry/EmbedPoints.h"
#include "Registration/Untangle.h"

namespace kerf {
namespace {

constexpr double kAbove_mm =
    15.0;  // S starts this far in front of the line: the surface bulges and the line is a chord
constexpr int kPasses = 3;
constexpr double kSpacing_mm = 3.0;  // of the strip's rows

}  // namespace

CutSurface ExtrudeCut(const CutPolyline& line, const Vec3& direction, double depth_mm) {
  return ExtrudePolyline(line, direction, kAbove_mm, depth_mm, kSpacing_mm);
}

CutReport ApplyCut(const ModelCut& cut, const MethodOptions& options, Engine& engine,
                   RegistrationState* state) {
  if (engine.observer) engine.observer->Begin(Stage::Cutting);
  CutReport report;
  const TopologyChange change =
      engine.cutter.Cut(state->mesh, cut.surface, &report, &state->positions);
  for (ModelCut& known : state->cuts)
    if (&known == &cut) {
      known.in_model = known.in_model || change.changed;
      known.partial = known.in_model && report.partial;
    }
  if (!change.changed) return report;
  if (engine.observer) engine.observer->Begin(Stage::Structures);
  // Everything that follows the mesh, side by side: none of it reads what another one writes.
  tbb::parallel_invoke([&] { engine.solvers.organ->Apply(change); },
                       [&] {
                         if (!engine.solvers.grips || state->grips.positions.rows() == 0) return;
                         engine.solvers.grips->Apply(change);
                         FollowCut(change, &state->grips);
                       },
                       [&] {
                         for (Structure& structure : state->structures)
                           structure = CutStructureSurface(structure, cut.surface, change,
                                                           state->mesh, options.structure_mode);
                       },
                       [&] {
                         state->boundary =
                             FollowCut(state->boundary, state->mesh, change, state->blind_outline);
                       });
  state->positions = change.MapVertexField(state->positions);
  state->velocities = change.MapVertexField(state->velocities);
  state->bound.embedding = change.MapEmbedding(state->bound.embedding, state->mesh);
  state->mesh = change.mesh;
  return report;
}

/// Where the material at the uncut mesh's vertices is now. Old vertices keep their numbers through
/// every cut, but some have been moved onto S.
void PlacesNow(const RegistrationState& state, CutModel* model) {
  const Index n = model->mesh.VertexCount();
  model->positions = state.positions.topRows(n);
  model->grip_positions = state.grips.positions.topRows(n);
  std::vector<Index> moved;
  for (Index v = 0; v < n; ++v)
    if (state.mesh.rest.row(v) != model->mesh.rest.row(v)) moved.push_back(v);
  if (!moved.empty()) {
    Points rest(moved.size(), 3);
    for (std::size_t k = 0; k < moved.size(); ++k) rest.row(k) = model->mesh.rest.row(moved[k]);
    const Embedding at = EmbedPoints(state.mesh, rest);
    const Points now = at.Positions(state.positions, state.mesh.tets);
    const Points held = at.Positions(state.grips.positions, state.mesh.tets);
    for (std::size_t k = 0; k < moved.size(); ++k) {
      model->positions.row(moved[k]) = now.row(k);
      model->grip_positions.row(moved[k]) = held.row(k);
    }
  }
}

std::optional<CutModel> CutAnew(const std::vector<ModelCut>& cuts, const MethodOptions& options,
                                const RegistrationState& state, bool whole, const Points* start) {
  if (!state.origin) return std::nullopt;
  CutModel model;
  model.mesh = state.origin->mesh;
  model.features = state.origin->features;
  if (whole) model.structures = state.origin->structures;
  if (start) {
    model.positions = model.grip_positions = *start;
  } else {
    PlacesNow(state, &model);
  }
  model.uncut.resize(cuts.size());
  for (std::size_t c = 0; c < cuts.size(); ++c) {
    const ModelCut& cut = cuts[c];
    if (!cut.in_model || cut.rejected) continue;
    // A whole S at once leaves bridges where it cannot keep the elements well shaped everywhere;
    // looked at afresh, most of them can be cut.
    bool any = false;
    for (int pass = 0; pass < kPasses; ++pass) {
      model.cutter = TetCutter();
      CutReport report;
      const TopologyChange change = model.cutter.Cut(model.mesh, cut.surface, &report);
      model.uncut[c] = report.partial ? report.reason : "";
      if (!change.changed) break;
      any = true;
      model.positions = change.MapVertexField(model.positions);
      model.grip_positions = change.MapVertexField(model.grip_positions);
      model.features = change.MapEmbedding(model.features, model.mesh);
      for (Structure& structure : model.structures)
        structure =
            CutStructureSurface(structure, cut.surface, change, model.mesh, options.structure_mode);
      model.mesh = change.mesh;
    }
    if (!any) return std::nullopt;
  }
  if (whole) model.boundary = MakeBoundaryTopology(model.mesh, state.blind_outline);
  // What lies between the old S and the new one starts on the wrong side of the gap.
  if (!start) {
    Untangle(model.mesh, &model.positions);
    Untangle(model.mesh, &model.grip_positions);
  }
  return model;
}

void Adopt(CutModel model, const MethodOptions& options, Engine& engine, RegistrationState* state) {
  for (std::size_t c = 0; c < std::min(model.uncut.size(), state->cuts.size()); ++c)
    state->cuts[c].partial = !model.uncut[c].empty();
  state->mesh = std::move(model.mesh);
  state->positions = std::move(model.positions);
  state->velocities = Points::Zero(state->mesh.VertexCount(), 3);
  state->bound.embedding = std::move(model.features);
  state->structures = std::move(model.structures);
  state->boundary = std::move(model.boundary);
  engine.cutter = std::move(model.cutter);
  const bool prepared = model.solvers.organ && model.solvers.grips;
  if (prepared)
    engine.solvers = std::move(model.solvers);
  else
    engine.solvers.organ->Reset(state->mesh, options.material);
  if (engine.solvers.grips) {
    if (!prepared) {
      engine.solvers.grips->Reset(state->mesh, options.material);
      state->grips.fields.clear();
    }
    state->grips.positions = std::move(model.grip_positions);
    state->grips.settled = false;
  }
}

}  // namespace kerf
