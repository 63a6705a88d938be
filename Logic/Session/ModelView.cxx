#include "Session/ModelView.h"

#include "Registration/CutLine.h"

namespace kerf {

const OrganView& ModelView::Update(const RegistrationState& state) {
  if (watch_.Changed(state.mesh)) {
    const SurfaceMesh rest = BoundarySurface(state.mesh, state.mesh.rest, &vertex_of_point_);
    view_.rest = rest.points;
    view_.current.triangles = rest.triangles;
    view_.cut_face = state.cuts.empty() ? std::vector<std::uint8_t>(rest.triangles.rows(), 0)
                                        : CutFaceFlags(rest, uncut_);
  }
  view_.current.points.resize(vertex_of_point_.size(), 3);
  for (std::size_t i = 0; i < vertex_of_point_.size(); ++i)
    view_.current.points.row(i) = state.positions.row(vertex_of_point_[i]);
  return view_;
}

SurfaceMesh CurrentSurface(const Structure& structure, const RegistrationState& state) {
  return {structure.embedding.Positions(state.positions, state.mesh.tets),
          structure.rest.triangles};
}

}  // namespace kerf
