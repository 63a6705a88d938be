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
/// Of several cuts each adds what it changes of the plain stretch, u_x − ε·h; away from the middle,
/// where the stretch is less, in proportion to it. What a cut adds falls off as a²/h², so that the
/// slope stays positive where the sheets are well apart.
class PhantomMotion {
 public:
  explicit PhantomMotion(const PhantomMotionParameters& parameters) : m_(parameters) {}

  int CutCount() const { return static_cast<int>(m_.cuts.size()); }
  /// Signed distance along x from the sheet of a cut; the sheet itself is 0.
  double SheetDistance_mm(const Vec3& rest, int cut) const;
  double SheetX_mm(double y_mm, int cut) const;
  /// Depth from the edge where the cut enters.
  double Depth_mm(const Vec3& rest, int cut) const;
  /// Depth of the tip at a (fractional) frame; 0 before the cut.
  double TipDepth_mm(double frame, int cut) const;
  /// Far-field strain ε at a frame.
  double Strain(double frame) const;
  /// The piece between the sheets that holds the point: 0 on the −x side of all, CutCount() on the
  /// +x side of all.
  int Region(const Vec3& rest) const;

  /// Where the material point is at `frame`. @param region used for points on a sheet only: which
  /// of its sides is meant
  Vec3 Position(const Vec3& rest, int region, double frame) const;
  /// Distance between the lips of a cut at a depth, at `frame`.
  double Opening_mm(double depth_mm, double frame, int cut) const;
  const PhantomMotionParameters& Parameters() const { return m_; }

 private:
  static constexpr int kFields = 3;
  /// Distance h that the strain stretches at a signed distance, and its slope: fading with tanh.
  struct Faded {
    double h, slope;
  };
  Faded Fade(double distance_mm) const;
  /// Depths a of the fields whose mean is taken; the last is the tip itself.
  std::array<double, kFields> FieldDepths_mm(double frame, int cut) const;
  /// Section about which everything stretches, curved as the first sheet.
  double MiddleX_mm(double y_mm) const;
  /// Slope of the plain stretch where the cut enters; 1 in the middle.
  double Share(int cut) const;

  PhantomMotionParameters m_;
};

}  // namespace kerf
