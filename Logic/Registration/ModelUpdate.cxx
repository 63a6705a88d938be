#include "Registration/ModelUpdate.h"

#include "Cutting/ExtrudePolyline.h"
#include "Registration/Untangle.h"

namespace kerf {
namespace {

constexpr double kAbove_mm =
    15.0;  // S starts this far in front of the line: the surface bulges and the line is a chord
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
  if (!change.changed) return report;
  engine.solver.Apply(change);
  state->positions = change.MapVertexField(state->positions);
  state->velocities = change.MapVertexField(state->velocities);
  if (engine.grips && state->grips.positions.rows() > 0) {
    engine.grips->Apply(change);
    state->grips.positions = change.MapVertexField(state->grips.positions);
    state->grips.velocities = change.MapVertexField(state->grips.velocities);
  }
  state->bound.embedding = change.MapEmbedding(state->bound.embedding, state->mesh);
  if (engine.observer) engine.observer->Begin(Stage::Structures);
  for (Structure& structure : state->structures)
    structure =
        CutStructureSurface(structure, cut.surface, change, state->mesh, options.structure_mode);
  state->mesh = change.mesh;
  state->boundary = MakeBoundaryTopology(state->mesh, state->blind_outline);
  return report;
}

std::optional<CutModel> CutAnew(const std::vector<ModelCut>& cuts, const MethodOptions& options,
                                const RegistrationState& state, bool structures) {
  if (!state.origin) return std::nullopt;
  CutModel model;
  model.mesh = state.origin->mesh;
  model.features = state.origin->features;
  if (structures) model.structures = state.origin->structures;
  // Old vertices keep their numbers through every cut.
  model.positions = state.positions.topRows(model.mesh.VertexCount());
  model.grip_positions = state.grips.positions.topRows(model.mesh.VertexCount());
  for (const ModelCut& cut : cuts) {
    if (cut.held || cut.rejected || cut.surface.triangles.rows() == 0) continue;
    const TopologyChange change = model.cutter.Cut(model.mesh, cut.surface);
    if (!change.changed) return std::nullopt;
    model.positions = change.MapVertexField(model.positions);
    model.grip_positions = change.MapVertexField(model.grip_positions);
    model.features = change.MapEmbedding(model.features, model.mesh);
    for (Structure& structure : model.structures)
      structure =
          CutStructureSurface(structure, cut.surface, change, model.mesh, options.structure_mode);
    model.mesh = change.mesh;
  }
  // What lies between the old S and the new one starts on the wrong side of the gap.
  Untangle(model.mesh, &model.positions);
  Untangle(model.mesh, &model.grip_positions);
  return model;
}

void Adopt(CutModel model, const MethodOptions& options, Engine& engine, RegistrationState* state) {
  state->mesh = std::move(model.mesh);
  state->positions = std::move(model.positions);
  state->velocities = Points::Zero(state->mesh.VertexCount(), 3);
  state->bound.embedding = std::move(model.features);
  state->structures = std::move(model.structures);
  state->boundary = MakeBoundaryTopology(state->mesh, state->blind_outline);
  engine.cutter = std::move(model.cutter);
  engine.solver.Reset(state->mesh, options.material);
  if (engine.grips) {
    engine.grips->Reset(state->mesh, options.material);
    state->grips.positions = std::move(model.grip_positions);
    state->grips.velocities = Points::Zero(state->mesh.VertexCount(), 3);
  }
}

}  // namespace kerf
