#pragma once

#include "Adapters/Itk/Field.h"

namespace kerf {

struct RandomWalkerOptions {
  double sigma_hu = 12;     ///< difference of neighbours across which a walker goes with weight 1/e
  double tolerance = 1e-4;  ///< relative residual at which the solver stops
  int max_iterations = 2000;
};

/// Random walker (Grady 2006): probability that a walker from each voxel meets an object marker
/// first. Solves the Dirichlet problem of the graph Laplacian with weights w_ij =
/// exp(−(ΔI/σ)²)/spacing² by conjugate gradients over the voxels without marker. @param markers 0
/// undecided, 1 background, 2 object
/// @return 0..1, 1 and 0 at the markers. Undecided voxels without any marker in reach get 0.
ScalarField RandomWalk(const ScalarField& image, const Mask& markers,
                       const RandomWalkerOptions& options, Progress& progress);

}  // namespace kerf
