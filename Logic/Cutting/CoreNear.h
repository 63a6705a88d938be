#pragma once

#include <vector>

#include "Cutting/CutPatch.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {

/// Where the core of a patch stands to S: asked once for each vertex, and again where it moves.
class CoreNear {
 public:
  /// @param known vertex → where it stands (triangle −1: not known), or empty
  CoreNear(const SurfaceIndex& surface, const CutPatch& patch,
           const std::vector<SurfaceNear>& known);
  /// Asks anew for vertices that have moved.
  void Update(const SurfaceIndex& surface, const CutPatch& patch, const std::vector<int>& moved);

  /// Triangle −1: not of the core, or S is farther than any edge to the core is long.
  const SurfaceNear& operator[](int v) const { return near_[v]; }
  const std::vector<SurfaceNear>& All() const { return near_; }
  /// Tetrahedra with all corners in the core, ascending.
  const std::vector<int>& Tets() const { return tets_; }

 private:
  void Measure(const CutPatch& patch);

  std::vector<int> tets_;
  std::vector<double> longest2_;  ///< of the edges to other vertices of the core, squared
  std::vector<SurfaceNear> near_;
};

/// Marks vertices that lie on S already, all others as off S.
void MarkVerticesOnS(const SurfaceIndex& surface, const CoreNear& near, CutPatch* patch);

}  // namespace kerf
