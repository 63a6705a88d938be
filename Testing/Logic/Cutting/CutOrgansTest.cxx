/// Cuts through meshes as Kerf gets them: the phantom's kidney from its own mesher, and one read
/// from a file.
#include <gtest/gtest.h>

#include <map>

#include "Adapters/Vtk/MeshFiles.h"
#include "Cutting/DisjointSets.h"
#include "Cutting/TetCutter.h"
#include "Fuzz/CutSequences.h"
#include "Meshing/TetMesher.h"
#include "Phantom/PhantomAnatomy.h"
#include "Phantom/PhantomScenario.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

TetMesh PhantomKidney() {
  static const TetMesh mesh = [] {
    const PhantomAnatomy anatomy =
        BuildPhantomAnatomy(MakePhantomSetup(PhantomScenario::KidneyNoCut, 1));
    MeshingOptions options;
    options.tetrahedra = 2500;
    Progress progress;
    return MeshClosedSurface(anatomy.organ, "phantom", options, progress);
  }();
  return mesh;
}

struct Organ {
  const char* name;
  TetMesh (*make)();
  friend std::ostream& operator<<(std::ostream& out, const Organ& o) { return out << o.name; }
};

class CutOrgans : public ::testing::TestWithParam<Organ> {
 protected:
  /// Cuts once; every guarantee is checked.
  void CutAndCheck(const CutSurface& surface, int pieces) {
    CutSequence sequence;
    sequence.mesh = mesh_;
    sequence.surfaces = {surface};
    sequence.completes = {std::nullopt};
    sequence.cut = {0};
    EXPECT_EQ(RunCutSequence(sequence).failure, "");
    CutReport report;
    const TopologyChange change = TetCutter().Cut(mesh_, surface, &report);
    ASSERT_TRUE(report.done) << report.reason;
    EXPECT_FALSE(report.partial) << report.reason;
    EXPECT_EQ(report.components, pieces);
    if (pieces == 2) {  // both of a size that counts
      std::vector<double> volumes = report.component_volume_mm3;
      std::sort(volumes.rbegin(), volumes.rend());
      EXPECT_GT(volumes[1], 0.1 * volumes[0]);
    }
  }

  /// Through the whole organ.
  CutSurface Plane(const Vec3& through, const Vec3& normal) const {
    const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
    return RectangleCut(through - 150 * u - 150 * v, 300 * u, 300 * v, 60, 60);
  }

  /// A tetrahedron in the middle.
  Index Middle() const {
    const Vec3 center = mesh_.rest.colwise().mean().transpose();
    Index best = 0;
    double nearest = 1e300;
    for (Index t = 0; t < mesh_.TetCount(); ++t) {
      const double d = (mesh_.rest.row(mesh_.tets(t, 0)).transpose() - center).norm();
      if (d < nearest) {
        nearest = d;
        best = t;
      }
    }
    return best;
  }

  Vec3 Corner(Index t, int k) const { return mesh_.rest.row(mesh_.tets(t, k)).transpose(); }

  const TetMesh mesh_ = GetParam().make();
};

TEST_P(CutOrgans, RandomSequencesKeepEveryGuarantee) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const CutSequence sequence = MakeCutSequence(seed, mesh_, GetParam().name);
    const CutSequenceResult result = RunCutSequence(sequence);
    EXPECT_EQ(result.failure, "") << "seed " << seed << " " << sequence.name;
    EXPECT_EQ(result.missed_separations, 0) << "seed " << seed << " " << sequence.name;
  }
}

TEST_P(CutOrgans, PlaneExactlyThroughAVertex) {
  const Vec3 p = Corner(Middle(), 0);
  CutAndCheck(Plane(p, Vec3::UnitX()), 2);
  CutAndCheck(Plane(p, Vec3(1, 2, -0.5).normalized()), 2);
}

TEST_P(CutOrgans, PlaneExactlyThroughAnEdge) {
  const Vec3 p = Corner(Middle(), 0), q = Corner(Middle(), 1);
  CutAndCheck(Plane(p, (q - p).unitOrthogonal()), 2);
}

TEST_P(CutOrgans, PlaneExactlyThroughAFace) {
  const Vec3 p = Corner(Middle(), 0), q = Corner(Middle(), 1), r = Corner(Middle(), 2);
  CutAndCheck(Plane((p + q + r) / 3, (q - p).cross(r - p).normalized()), 2);
}

/// S made of the mesh's own faces, those between the tetrahedra on either side of a plane: as rough
/// as the elements are. What hangs together on either side of it becomes a piece, chips aside.
TEST_P(CutOrgans, SurfaceOfTheMeshsOwnFaces) {
  const double at = mesh_.rest.col(0).mean();
  auto ahead = [&](Index t) {
    double x = 0;
    for (int k = 0; k < 4; ++k) x += mesh_.rest(mesh_.tets(t, k), 0) / 4;
    return x > at;
  };
  std::map<std::array<Index, 3>, Index> first_at;
  std::vector<std::array<Index, 3>> between;
  DisjointSets joined(mesh_.TetCount());
  for (Index t = 0; t < mesh_.TetCount(); ++t)
    for (int k = 0; k < 4; ++k) {
      std::array<Index, 3> face;
      for (int j = 0, n = 0; j < 4; ++j)
        if (j != k) face[n++] = mesh_.tets(t, j);
      std::sort(face.begin(), face.end());
      const auto [it, first] = first_at.insert({face, t});
      if (first) continue;
      if (ahead(t) != ahead(it->second))
        between.push_back(face);
      else
        joined.Join(t, it->second);
    }
  CutSurface surface;
  surface.points = mesh_.rest;
  surface.triangles.resize(between.size(), 3);
  for (std::size_t f = 0; f < between.size(); ++f)
    for (int k = 0; k < 3; ++k) surface.triangles(f, k) = between[f][k];
  std::map<Index, double> volume_of;
  double volume = 0;
  for (Index t = 0; t < mesh_.TetCount(); ++t) {
    const double v = TetVolume(mesh_.rest, mesh_.tets, t);
    volume += v;
    volume_of[joined.Find(t)] += v;
  }
  std::vector<double> pieces;
  double chips = 0;
  for (const auto& [root, v] : volume_of)
    if (v > 3 * volume / mesh_.TetCount())
      pieces.push_back(v);
    else
      chips += v;
  ASSERT_EQ(pieces.size(), 2u);
  CutAndCheck(surface, 2);
  CutReport report;
  TetCutter().Cut(mesh_, surface, &report);
  std::sort(pieces.begin(), pieces.end());
  std::sort(report.component_volume_mm3.begin(), report.component_volume_mm3.end());
  for (int piece : {0, 1})
    EXPECT_NEAR(report.component_volume_mm3[piece], pieces[piece], chips + 1e-9 * volume);
}

INSTANTIATE_TEST_SUITE_P(
    Organs, CutOrgans,
    ::testing::Values(Organ{"phantom", PhantomKidney},
                      Organ{"file", [] { return ReadTetMesh(KERF_CUTTING_DATA "/organ.vtu"); }}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace kerf::testing
