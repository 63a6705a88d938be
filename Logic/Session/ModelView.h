#pragma once

#include <cstdint>
#include <vector>

#include "Geometry/SurfaceTree.h"
#include "Registration/MeshWatch.h"
#include "Registration/RegistrationState.h"

namespace kerf {

/// The organ's boundary as it is in a state. What depends on the topology alone is kept from frame
/// to frame.
struct OrganView {
  SurfaceMesh current;                 ///< LPS, mm
  Points rest;                         ///< rest positions of the same points
  std::vector<std::uint8_t> cut_face;  ///< per triangle: face of a cut
};

class ModelView {
 public:
  /// @param uncut the organ's rest surface before any cut; must outlive the view
  explicit ModelView(const SurfaceTree& uncut) : uncut_(uncut) {}
  /// Valid until the next call.
  const OrganView& Update(const RegistrationState& state);

 private:
  const SurfaceTree& uncut_;
  OrganView view_;
  std::vector<Index> vertex_of_point_;
  MeshWatch watch_;
};

/// Surface of an inner structure in a state, LPS, mm.
SurfaceMesh CurrentSurface(const Structure& structure, const RegistrationState& state);

}  // namespace kerf
