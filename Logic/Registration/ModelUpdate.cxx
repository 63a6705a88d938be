#include "Registration/ModelUpdate.h"

#include "Cutting/ExtrudePolyline.h"

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

}  // namespace kerf
