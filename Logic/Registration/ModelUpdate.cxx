#include "Registration/ModelUpdate.h"

#include "Cutting/ExtrudePolyline.h"

namespace kerf {
namespace {

constexpr double kAbove_mm =
    15.0;  // S starts this far in front of the line: the surface bulges and the line is a chord
constexpr double kSpacing_mm = 3.0;  // of the strip's rows

}  // namespace

CutSurface ExtrudeCut(const CutPolyline& line, const CameraModel& camera,
                      const MethodOptions& options, double depth_mm) {
  Points directions(line.points.rows(), 3);
  const Vec3 direction = options.extrusion ? *options.extrusion : camera.ViewDirection();
  for (Index i = 0; i < directions.rows(); ++i) directions.row(i) = direction.transpose();
  return ExtrudePolyline(line.points, directions, kAbove_mm, depth_mm, kSpacing_mm);
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
  state->bound.embedding = change.MapEmbedding(state->bound.embedding, state->mesh);
  if (engine.observer) engine.observer->Begin(Stage::Structures);
  for (Structure& structure : state->structures)
    structure =
        CutStructureSurface(structure, cut.surface, change, state->mesh, options.structure_mode);
  state->mesh = change.mesh;
  return report;
}

}  // namespace kerf
