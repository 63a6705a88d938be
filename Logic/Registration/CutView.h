#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "Core/Embedding.h"
#include "Registration/MeshWatch.h"
#include "Registration/RegistrationState.h"

namespace kerf {

/// The cuts of a model as they lie on the moved organ, for those who draw them. What depends on the
/// topology alone is kept from frame to frame.
class CutView {
 public:
  /// Takes over the cuts of this frame. @param cut_face what CutFaceFlags says of the mesh's
  /// boundary, for who has it already; null: asked for here
  void Update(const RegistrationState& state, const std::vector<std::uint8_t>* cut_face = nullptr);

  /// Cut lines on the current organ surface, N×3 in order, LPS, mm: where the mesh is cut its lips,
  /// as far as the cut's line goes (the mesh opens to the next vertex beyond); where a cut is only
  /// proposed its line. Parted where a line leaves the surface.
  const std::vector<Points>& Lips() const { return lips_; }
  /// Number of the cut that each lip belongs to.
  const std::vector<int>& LipCuts() const { return lip_cuts_; }
  /// Smallest distance between the tumour's surface and a face of a cut, both as they are now, mm:
  /// 0 where the cut goes through the tumour; NaN without a tumour or without a cut.
  double TumourMargin_mm() const { return margin_mm_; }

 private:
  void Rebind(const RegistrationState& state, const std::vector<std::uint8_t>* cut_face);

  /// Whether the lines of the cuts are others than at the last call.
  bool LinesChanged(const RegistrationState& state);

  MeshWatch watch_;
  std::vector<std::pair<Points, Vec3>> lines_;  ///< of the last call, with their directions of view
  std::vector<Embedding> bound_;                ///< of each lip, as in `lips_`
  std::vector<int> lip_cuts_;
  Triangles faces_;  ///< of the cuts, in mesh vertices
  std::vector<Points> lips_;
  double margin_mm_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace kerf
