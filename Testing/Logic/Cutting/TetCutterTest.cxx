#include <gtest/gtest.h>

#include <cmath>

#include "Core/Errors.h"
#include "Cutting/ExtrudePolyline.h"
#include "Cutting/TetCutter.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

struct Case {
  TetMesh mesh;
  double volume_mm3;
  TetCutter cutter;
  CutReport report;

  explicit Case(TetMesh start)
      : mesh(std::move(start)), volume_mm3(MeasureQuality(mesh, mesh.rest).volume_mm3) {}

  /// Cuts and checks what must hold after every increment.
  TopologyChange Cut(const CutSurface& surface) {
    TopologyChange change = cutter.Cut(mesh, surface, &report);
    EXPECT_EQ(change.changed, report.done);
    const MeshQuality q = MeasureQuality(change.mesh, change.mesh.rest);
    EXPECT_EQ(q.inverted, 0);
    EXPECT_EQ(q.orphans, 0);
    EXPECT_TRUE(q.manifold_boundary);
    EXPECT_NEAR(q.volume_mm3 / volume_mm3, 1, 1e-9);
    EXPECT_GE(q.smallest_dihedral_deg, 3);
    EXPECT_EQ(q.components, report.components);
    double pieces = 0;
    for (double v : report.component_volume_mm3) pieces += v;
    EXPECT_NEAR(pieces, volume_mm3, 1e-6 * volume_mm3);
    mesh = change.mesh;
    return change;
  }
};

/// Parallel to y and z through x, from y = −100 on.
CutSurface PlaneX(double x, double to_y, double z_low = -100, double z_high = 100) {
  const double length = to_y + 100;
  return RectangleCut({x, -100, z_low}, {0, length, 0}, {0, 0, z_high - z_low},
                      std::max(1, int(length / 3)), std::max(1, int((z_high - z_low) / 3)));
}

void ExpectFacesInPairs(const TopologyChange& change) {
  ASSERT_FALSE(change.opened.empty());
  for (const OpenedFace& face : change.opened)
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT((change.mesh.rest.row(face.a[k]) - change.mesh.rest.row(face.b[k])).norm(), 1e-9);
      EXPECT_TRUE((change.mesh.tets.row(face.tet_a).array() == face.a[k]).any());
      EXPECT_TRUE((change.mesh.tets.row(face.tet_b).array() == face.b[k]).any());
    }
}

TEST(TetCutter, CompleteCutGivesTwoPieces) {
  Case c(BandMesh(2000));
  c.Cut(PlaneX(3.1, 100));
  ASSERT_TRUE(c.report.done) << c.report.reason;
  ASSERT_EQ(c.report.components, 2);
  std::vector<double> pieces = c.report.component_volume_mm3;
  std::sort(pieces.begin(), pieces.end());
  EXPECT_NEAR(pieces[0], (60 - 3.1) * 400, 1e-6 * 48000);
  EXPECT_NEAR(c.report.cut_area_mm2, 400, 1e-6);
}

TEST(TetCutter, OptionsThatMeanNothingAreRefused) {
  CutOptions options;
  options.max_new_tets = -1;
  EXPECT_THROW(TetCutter{options}, UsageError);
  options = {};
  options.min_volume_share = std::nan("");
  EXPECT_THROW(TetCutter{options}, UsageError);
}

TEST(TetCutter, HalfCutStaysInOnePiece) {
  Case c(SphereMesh(30, 5));
  c.Cut(PlaneX(1.3, 2));
  ASSERT_TRUE(c.report.done) << c.report.reason;
  EXPECT_EQ(c.report.components, 1);
  EXPECT_GT(c.report.cut_area_mm2, 0.4 * M_PI * 900);
  EXPECT_LT(c.report.cut_area_mm2, 0.65 * M_PI * 900);
}

TEST(TetCutter, TwentyIncrementsAreAsGoodAsOne) {
  Case grown(EllipsoidMesh({55, 35, 25}, 5)), once(grown.mesh);
  for (int i = 1; i <= 20; ++i) grown.Cut(PlaneX(2.3, -100 + 7.0 * i));
  once.Cut(PlaneX(2.3, 40));
  EXPECT_EQ(grown.report.components, 2);
  EXPECT_EQ(once.report.components, 2);
  EXPECT_NEAR(grown.report.component_volume_mm3[0], once.report.component_volume_mm3[0],
              0.02 * grown.volume_mm3);
  EXPECT_LT(grown.mesh.TetCount() - once.mesh.TetCount(), 0.25 * once.mesh.TetCount());
}

TEST(TetCutter, AgainAlongTheSameSurfaceChangesNothing) {
  Case c(SphereMesh(30, 4));
  const CutSurface s = PlaneX(1.3, 100);
  c.Cut(s);
  ASSERT_TRUE(c.report.done);
  const TetMesh before = c.mesh;
  c.Cut(s);
  EXPECT_FALSE(c.report.done);
  TetCutter stranger;  // remembers nothing, has to see it from the mesh
  CutReport report;
  const TopologyChange change = stranger.Cut(before, s, &report);
  EXPECT_FALSE(report.done);
  EXPECT_EQ(change.mesh.tets, before.tets);
  EXPECT_FALSE(report.reason.empty());
}

TEST(TetCutter, DepthLimitedCutLeavesTheBottomJoined) {
  Case c(BoxMesh({40, 40, 40}, 8, 8, 8));
  c.Cut(PlaneX(1.7, 100, -2.0));
  ASSERT_TRUE(c.report.done) << c.report.reason;
  EXPECT_EQ(c.report.components, 1);
  EXPECT_NEAR(c.report.cut_area_mm2, 40 * 22, 40 * 5);  // the front is within an element of S's end
}

TEST(TetCutter, CrossingCutsGiveFourPieces) {
  Case c(SphereMesh(30, 5));
  c.Cut(PlaneX(0.7, 100));
  EXPECT_EQ(c.report.components, 2);
  c.Cut(RectangleCut({-100, 1.1, -100}, {200, 0, 0}, {0, 0, 200}, 60, 60));
  EXPECT_EQ(c.report.components, 4);
}

TEST(TetCutter, TeeCutsOnlyTheSideItEnters) {
  Case c(SphereMesh(30, 5));
  c.Cut(PlaneX(0.7, 100));
  c.Cut(RectangleCut({0.7, 1.1, -100}, {100, 0, 0}, {0, 0, 200}, 60, 60));
  EXPECT_EQ(c.report.components, 3);
}

TEST(TetCutter, SeveralCutsAtOnce) {
  Case c(BandMesh(3000));
  c.Cut(Together(PlaneX(-20.3, 100), PlaneX(15.2, 100)));
  EXPECT_EQ(c.report.components, 3);
}

TEST(TetCutter, SheetsOfOneSurfaceMayCross) {
  const CutSurface across = RectangleCut({-100, 1.1, -100}, {200, 0, 0}, {0, 0, 200}, 60, 60);
  Case at_once(SphereMesh(30, 5)), one_by_one(SphereMesh(30, 5));
  const TopologyChange change = at_once.Cut(Together(PlaneX(0.7, 100), across));
  EXPECT_EQ(at_once.report.components, 4);
  ExpectFacesInPairs(change);
  double area_mm2 = 0;
  for (const OpenedFace& face : change.opened) {
    const Vec3 p = change.mesh.rest.row(face.a[0]);
    area_mm2 += 0.5 * (change.mesh.rest.row(face.a[1]).transpose() - p)
                          .cross(change.mesh.rest.row(face.a[2]).transpose() - p)
                          .norm();
  }
  EXPECT_NEAR(area_mm2 / at_once.report.cut_area_mm2, 1, 0.02);

  one_by_one.Cut(PlaneX(0.7, 100));
  one_by_one.Cut(Together(PlaneX(0.7, 100), across));  // as it was, and another across it
  EXPECT_EQ(one_by_one.report.components, 4);
}

TEST(TetCutter, CutsInsideOpenAClosedSlit) {
  Case c(BoxMesh({40, 40, 40}, 8, 8, 8));
  c.Cut(RectangleCut({1.7, -12, -12}, {0, 24, 0}, {0, 0, 24}, 8, 8));
  ASSERT_TRUE(c.report.done) << c.report.reason;
  EXPECT_EQ(c.report.components, 1);
}

TEST(TetCutter, ExactlyThroughVerticesEdgesAndFaces) {
  Case c(BoxMesh({40, 40, 40}, 4, 4, 4));
  c.Cut(PlaneX(10, 100));  // a plane of the grid
  EXPECT_EQ(c.report.components, 2);
  EXPECT_EQ(c.report.new_tets, 0);
  EXPECT_NEAR(c.report.cut_area_mm2, 1600, 1e-6);
}

TEST(TetCutter, GrazingTheBoundaryCutsNothing) {
  Case c(BoxMesh({40, 40, 40}, 4, 4, 4));
  c.Cut(PlaneX(20, 100));
  EXPECT_FALSE(c.report.done);
  c.Cut(PlaneX(20.5, 100));
  EXPECT_FALSE(c.report.done);
  EXPECT_EQ(c.report.components, 1);
}

TEST(TetCutter, CurvedCut) {
  Case c(EllipsoidMesh({55, 35, 25}, 6));
  Points line(25, 3), down(1, 3);
  for (int i = 0; i < 25; ++i) {
    const double y = -48 + 4.0 * i;
    line.row(i) << 8 * std::sin(0.06 * y), y, 30;
  }
  down << 0.1, 0, -1;
  c.Cut(ExtrudePolyline(line, down, 5, 80, 2.5));
  EXPECT_EQ(c.report.components, 2);
}

TEST(TetCutter, KeepsRegions) {
  TetMesh mesh = SphereMesh(30, 5);
  PaintSphere({0, 0, 0}, 12, Label::Tumour, &mesh);
  auto tumour_volume = [](const TetMesh& m) {
    double v = 0;
    for (Index t = 0; t < m.TetCount(); ++t)
      if (m.region[t] == static_cast<std::uint8_t>(Label::Tumour))
        v += TetVolume(m.rest, m.tets, t);
    return v;
  };
  Case c(mesh);
  c.Cut(PlaneX(1.3, 100));
  ASSERT_TRUE(c.report.done);
  EXPECT_NEAR(tumour_volume(c.mesh) / tumour_volume(mesh), 1, 0.15);  // its faces snap with it
}

TEST(TetCutter, OpenedFacesCoincideAndTellTheirTetrahedra) {
  Case c(SphereMesh(30, 4));
  const TopologyChange change = c.Cut(PlaneX(1.3, 100));
  ExpectFacesInPairs(change);
  for (const OpenedFace& face : change.opened)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(change.mesh.rest(face.a[k], 0), 1.3, 0.5);
}

TEST(TetCutter, EmptySurfaceAndMissAreSaid) {
  TetMesh mesh = SphereMesh(10, 2);
  CutReport report;
  CutSurface nothing;
  nothing.points.resize(0, 3);
  nothing.triangles.resize(0, 3);
  EXPECT_FALSE(TetCutter().Cut(mesh, nothing, &report).changed);
  EXPECT_NE(report.reason.find("empty"), std::string::npos);
  EXPECT_FALSE(TetCutter().Cut(mesh, PlaneX(50, 100), &report).changed);
  EXPECT_NE(report.reason.find("does not meet"), std::string::npos);
}

/// Waves through the whole organ, cut at once on badly shaped meshes, where S grazes edges that are
/// not split: no bridge is left without a word.
TEST(TetCutter, WholeWavesAtOncePartTheOrgan) {
  constexpr int kCells = 40;
  int partial = 0;
  for (int seed = 0; seed < 30; ++seed) {
    const TetMesh mesh = Jitter(SphereMesh(30, 4 + seed % 3), 0.8, 8, 1 + seed);
    const Vec3 normal = Vec3(1, 0.1 * seed - 1.5, 0.07 * (seed * 7 % 30) - 1).normalized();
    const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
    CutSurface wave = RectangleCut(-50 * u - 50 * v, 100 * u, 100 * v, kCells, kCells);
    for (Index i = 0; i < wave.points.rows(); ++i) {
      const Vec3 p = wave.points.row(i).transpose();
      const double phase = 0.02 * (1 + seed % 4) * (p.dot(u) + 0.5 * p.dot(v)) + seed;
      wave.points.row(i) += (1 + seed % 6) * std::sin(phase) * normal.transpose();
    }
    CutReport report;
    TetCutter().Cut(mesh, wave, &report);
    EXPECT_TRUE(report.done) << seed << ": " << report.reason;
    if (report.partial)
      ++partial;
    else
      EXPECT_EQ(report.components, 2) << seed;
  }
  EXPECT_LE(partial, 1);
}

TEST(TetCutter, BrokenInputIsRefusedByNameAndForgotten) {
  Case c(SphereMesh(10, 3));
  const CutSurface good = PlaneX(1.3, 100);
  const auto problem = [&](const CutSurface& surface, const Points* positions) -> std::string {
    try {
      c.cutter.Cut(c.mesh, surface, nullptr, positions);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    CutSurface broken = good;
    broken.points(7, 1) = bad;
    const std::string said = problem(broken, nullptr);
    EXPECT_NE(said.find("point 7"), std::string::npos) << said;
    EXPECT_NE(said.find("not finite"), std::string::npos) << said;
  }
  CutSurface broken = good;
  broken.triangles(5, 2) = static_cast<Index>(good.points.rows());
  EXPECT_NE(problem(broken, nullptr).find("triangle 5"), std::string::npos);
  const Points few = c.mesh.rest.topRows(9);
  EXPECT_NE(problem(good, &few).find("positions"), std::string::npos);
  c.Cut(good);
  EXPECT_EQ(c.report.components, 2) << "nothing is remembered of what was refused";
}

TEST(TetCutter, SameInputSameBits) {
  const TetMesh mesh = Jitter(SphereMesh(30, 5), 0.7, 8, 3);
  const auto a = TetCutter().Cut(mesh, PlaneX(1.3, 5)), b = TetCutter().Cut(mesh, PlaneX(1.3, 5));
  ASSERT_TRUE(a.changed);
  EXPECT_EQ(a.mesh.rest, b.mesh.rest);
  EXPECT_EQ(a.mesh.tets, b.mesh.tets);
}

/// Bounds on the volume and on the growth hold for what is cut: another attempt is made, or the
/// increment is refused and the mesh stays as it was.
TEST(TetCutter, SmallTetrahedraAndGrowthAreBounded) {
  int refused = 0, done = 0;
  for (const double share : {1e-5, 0.02, 0.2})
    for (const double growth : {4.0, 0.7, 0.4})
      for (const double x : {2.3, 7.9}) {
        CutOptions options;
        options.min_volume_share = share;
        options.max_new_vertices = growth;
        const TetMesh mesh = Jitter(EllipsoidMesh({55, 35, 25}, 4), 0.8, 8, 3);
        const MeshQuality before = MeasureQuality(mesh, mesh.rest);
        const double mean_mm3 = before.volume_mm3 / mesh.TetCount();
        CutReport report;
        const TopologyChange change = TetCutter(options).Cut(mesh, PlaneX(x, 100), &report);
        refused += !report.done;
        done += report.done;
        if (!report.done) {
          EXPECT_TRUE(report.partial);
          EXPECT_NE(report.reason.find("well shaped"), std::string::npos) << report.reason;
          EXPECT_EQ(change.mesh.tets, mesh.tets);
          continue;
        }
        for (Index t : change.new_tets)
          EXPECT_GE(TetVolume(change.mesh.rest, change.mesh.tets, t),
                    0.999 * std::min(share * mean_mm3, before.smallest_tet_volume_mm3));
        EXPECT_LE(change.mesh.VertexCount() - mesh.VertexCount(), growth * report.crossed_tets);
      }
  EXPECT_GT(refused, 0);
  EXPECT_GE(done, 4);
}

TEST(TetCutter, SnappingNeedsFewerTetrahedra) {
  const TetMesh mesh = EllipsoidMesh({55, 35, 25}, 6);
  CutOptions plain;
  plain.snapping = false;
  CutReport with, without;
  TetCutter().Cut(mesh, PlaneX(2.3, 100), &with);
  TetCutter(plain).Cut(mesh, PlaneX(2.3, 100), &without);
  ASSERT_TRUE(with.done && without.done);
  EXPECT_LT(with.new_tets, 0.7 * without.new_tets);
  EXPECT_GT(with.smallest_dihedral_deg, without.smallest_dihedral_deg);
}

}  // namespace
}  // namespace kerf::testing
