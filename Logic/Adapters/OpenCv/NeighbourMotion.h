#pragma once

#include <Eigen/Dense>
#include <vector>

#include "Adapters/OpenCv/PatchAligner.h"

/// Inside this component only: what the neighbours of a feature say about it. Neighbours are chosen
/// where the features were first seen, among those of the same frame: on the tissue they stay
/// neighbours when it is cut.
namespace kerf {

/// A feature as its neighbours see it.
struct NeighbourView {
  Eigen::Vector2f birth{0, 0};                          ///< where it was first seen, px
  Eigen::Vector2f now{0, 0};                            ///< where it is, px
  Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();  ///< deformation of its patch since then
  int generation = 0;  ///< features first seen in the same frame share it
  bool seen = false;   ///< tracked in this frame
};

class NeighbourMotion {
 public:
  void Build(const std::vector<NeighbourView>& features);
  /// Rows whose motion in this frame (px; NaN = unknown) is shared by fewer than two neighbours
  /// although three or more are known. Tissue on either side of a cut has neighbours on its own
  /// side, so a cut makes no loners.
  std::vector<int> Loners(const std::vector<Eigen::Vector2f>& motion,
                          const std::vector<NeighbourView>& features) const;
  /// True when hardly any neighbour lies where the deformation of both patches says that it should:
  /// the feature has slid along an edge or has been taken for another. Fits to second order in the
  /// distance, so stretch and bending do not count.
  bool Misplaced(int row, const NeighbourView& feature,
                 const std::vector<NeighbourView>& features) const;
  /// Where a feature that is not seen should be: from the places and the deformation of the
  /// neighbours that are.
  /// @return false where too few are seen
  bool Expected(int row, const std::vector<NeighbourView>& features, Eigen::Vector2f* place) const;
  /// Where the nearest, second nearest … of the neighbours that are seen alone expects it, and how
  /// deformed. @param nth from 0. @return false where fewer are seen
  bool ExpectedBy(int nth, int row, const std::vector<NeighbourView>& features,
                  AffineWarp* place) const;

 private:
  std::vector<std::vector<int>> neighbours_;  ///< nearest first
};

}  // namespace kerf
