#pragma once

#include <Eigen/Dense>
#include <vector>

/// Inside this component only: what the neighbours of a feature say about its motion between two
/// frames.
namespace kerf {

class NeighbourMotion {
 public:
  /// @param births where each feature was first seen: neighbours on the tissue stay neighbours when
  /// it is cut
  void Build(const std::vector<Eigen::Vector2f>& births);
  /// Rows whose motion (px; NaN = unknown) is shared by fewer than two neighbours although three or
  /// more are known. Tissue on either side of a cut has neighbours on its own side, so a cut makes
  /// no loners.
  std::vector<int> Loners(const std::vector<Eigen::Vector2f>& motion,
                          const std::vector<Eigen::Vector2f>& positions) const;
  /// Motion that the seen neighbours suggest for a feature that is not seen; zero where none is
  /// seen.
  Eigen::Vector2f Expected(int row, const std::vector<Eigen::Vector2f>& motion,
                           const std::vector<Eigen::Vector2f>& positions) const;

 private:
  std::vector<std::vector<int>> neighbours_;  ///< nearest first
};

}  // namespace kerf
