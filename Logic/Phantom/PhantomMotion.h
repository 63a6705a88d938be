#pragma once

#include <array>

#include "Phantom/PhantomScenario.h"

namespace kerf {

/// The phantom's motion in closed form, in organ axes (mm); no finite elements, nothing of Kerf's
/// registration.
///
/// The stretch follows the field of an edge crack in a half plane: with h(s) the signed distance
/// from the sheet (fading as a tanh), d the depth from the entry edge and a the depth of the cut,
///   u_x = ε · Re √((h + i d)² + a²),
/// which is ε·h without a cut, opens the mouth by 2·ε·√(a² − d²) behind the tip, is continuous
/// ahead of it, and never folds (∂u_x/∂x ≥ 0). The last millimetres behind the tip hold together a
/// little (the mean of three such fields), as a process zone does; that keeps the strain at the tip
/// finite in practice. The section contracts by the square root of the stretch, so that volume is
/// nearly kept.
class PhantomMotion {
 public:
  explicit PhantomMotion(const PhantomMotionParameters& parameters) : m_(parameters) {}

  /// Signed distance along x from the sheet; the sheet itself is 0.
  double SheetDistance_mm(const Vec3& rest) const;
  double SheetX_mm(double y_mm) const;
  double Depth_mm(const Vec3& rest) const { return rest.y() - m_.entry_y_mm; }
  /// Depth of the tip at a (fractional) frame; 0 before the cut.
  double TipDepth_mm(double frame) const;
  /// Far-field strain ε at a frame.
  double Strain(double frame) const;

  /// Where the material point is at `frame`. @param side of the sheet, −1 or +1, used for points on
  /// the sheet only
  Vec3 Position(const Vec3& rest, int side, double frame) const;
  /// Distance between the lips at a depth, at `frame`.
  double Opening_mm(double depth_mm, double frame) const;
  const PhantomMotionParameters& Parameters() const { return m_; }

 private:
  static constexpr int kFields = 3;
  /// Depths a of the fields whose mean is taken; the last is the tip itself.
  std::array<double, kFields> FieldDepths_mm(double frame) const;

  PhantomMotionParameters m_;
};

}  // namespace kerf
