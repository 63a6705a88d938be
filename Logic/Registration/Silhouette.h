#pragma once

#include <array>
#include <memory>
#include <vector>

#include "Core/Camera.h"
#include "Core/Embedding.h"
#include "Core/Frame.h"
#include "Core/TetMesh.h"
#include "Core/TopologyChange.h"

namespace kerf {

/// The boundary of the mesh as the silhouette needs it; changes only with the topology.
struct BoundaryTopology {
  Triangles triangles;                       ///< in mesh vertices, outwards
  std::vector<Index> tet_of_triangle;        ///< the tetrahedron behind each, in rising order
  std::vector<std::array<Index, 2>> edges;   ///< mesh vertices
  std::vector<std::array<Index, 2>> beside;  ///< the two triangles at each edge
  std::vector<char> blind;           ///< per mesh vertex: what hides the organ there hid it at rest
  std::vector<Index> tet_of_vertex;  ///< a tetrahedron at each boundary vertex, −1 inside
};
/// @param blind rest positions beside which the outline is not to be believed (N×3, mm; may be
/// empty)
BoundaryTopology MakeBoundaryTopology(const TetMesh& mesh, const Points& blind);
/// The same for the mesh after a cut, from what it was before: only faces at changed tetrahedra are
/// looked at. Vertices of the mesh before keep their numbers, as the cutter leaves them.
/// @param old of the mesh `before`, made with the same `blind`; of another one, all is made anew
BoundaryTopology FollowCut(const BoundaryTopology& old, const TetMesh& before,
                           const TopologyChange& change, const Points& blind);

/// Where the organ's outline is in the image, for points on the model's outline.
struct SilhouetteTargets {
  Embedding at;    ///< model points (vertices on the outline)
  Points targets;  ///< the same points moved across the line of sight onto the image's outline, mm
  Eigen::VectorXd confidence;  ///< 0..1
  Eigen::VectorXd off_px;      ///< from the model's outline to the image's, not shortened, >= 0
  Eigen::VectorXd length_px;   ///< of the model's outline that each point stands for
};

/// Along the normal of the model's outline, the place that best parts organ from background.
/// @param model_mask projection of these positions (ProjectedMask): tells the outline from folds
/// @param organ_mask 1 channel, raw image size, as OrganSegmenter gives it; another size of either
/// mask gives no targets
/// @param reach_px how far is searched to either side
SilhouetteTargets FindSilhouette(const BoundaryTopology& boundary, const TetMesh& mesh,
                                 const Points& positions, const CameraModel& camera,
                                 const Image& model_mask, const Image& organ_mask, int reach_px);

/// Places of the rest outline that the registered image does not show where the model has them:
/// something (a clamp, other tissue) hides the organ there. @return M×3 rest positions, mm
Points BlindOutline(const SilhouetteTargets& at_rest, const TetMesh& mesh,
                    const CameraModel& camera);

}  // namespace kerf
