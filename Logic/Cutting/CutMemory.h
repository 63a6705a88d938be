#pragma once

#include <cstdint>
#include <vector>

#include "Core/TopologyChange.h"

namespace kerf {

/// How far a separation surface has been dealt with: what a cutter remembers of one call for the
/// next. Triangles go by the bits of their corners.
struct CutMemory {
  std::vector<std::uint64_t> settled;  ///< nothing is left to do along them; ascending
  std::vector<std::uint64_t> left;     ///< S stayed uncut there; ascending
  Index vertices = -1, tets = -1;      ///< of the mesh that the call returned
  std::vector<double> component_volume_mm3;

  bool Knows(const TetMesh& mesh) const {
    return vertices == mesh.VertexCount() && tets == mesh.TetCount();
  }
};

/// The triangles of S in the light of what is remembered.
struct CutProgress {
  std::vector<std::uint64_t> hashes;
  std::vector<char> fresh;    ///< to be looked at: new ones, and what is to be tried again
  std::vector<char> waiting;  ///< S stayed uncut there, and it is not tried again now

  /// Where S stayed uncut it is tried again with every increment that comes within `near_mm`, and
  /// when nothing is new, at a cost that follows what is left.
  /// @param memory null: all is new
  CutProgress(const CutSurface& surface, const CutMemory* memory, double near_mm);
  bool Waits() const;
  /// Nothing came of it: what was tried again is settled, what is new will be looked at again.
  void SettleTriedAgain(CutMemory* memory) const;
  /// @param left triangles along which S stays uncut after this call
  void Remember(const std::vector<char>& left, CutMemory* memory) const;
};

}  // namespace kerf
