#include <gtest/gtest.h>

#include <map>

#include "Phantom/PhantomAnatomy.h"
#include "Phantom/PhantomCt.h"
#include "Phantom/PhantomShape.h"

namespace kerf {
namespace {

PhantomSetup Kidney(bool cut = true) {
  return MakePhantomSetup(cut ? PhantomScenario::KidneyCut : PhantomScenario::KidneyNoCut, 1);
}

TEST(PhantomAnatomy, LooksLikeAKidney) {
  const PhantomAnatomy anatomy = BuildPhantomAnatomy(Kidney(false));
  ASSERT_TRUE(anatomy.organ.IsClosedManifold());
  ASSERT_TRUE(anatomy.internal.IsClosedManifold());
  ASSERT_TRUE(anatomy.tumour.IsClosedManifold());
  EXPECT_EQ(anatomy.organ.Components(), 1);
  EXPECT_EQ(anatomy.internal.Components(), 1);
  const Vec3 organ =
      anatomy.organ.points.colwise().maxCoeff() - anatomy.organ.points.colwise().minCoeff();
  EXPECT_NEAR(organ.x(), 101.0, 5.0);
  EXPECT_NEAR(organ.y(), 53.0, 5.0);
  EXPECT_NEAR(organ.z(), 45.0, 5.0);
  EXPECT_NEAR(anatomy.organ.SignedVolume() / 1000.0, 122.0,
              12.0);  // mL; an adult kidney has 110–190
  EXPECT_NEAR(anatomy.internal.SignedVolume() / 1000.0, 3.0, 0.6);
  const double tumour = std::cbrt(anatomy.tumour.SignedVolume() * 6.0 / 3.14159265);
  EXPECT_GT(tumour, 10.0);
  EXPECT_LT(tumour, 16.0) << "mean diameter, mm";
}

TEST(PhantomAnatomy, StructuresLieInsideTheOrgan) {
  const PhantomAnatomy anatomy = BuildPhantomAnatomy(Kidney());
  for (Index p = 0; p < anatomy.tumour.points.rows(); ++p)
    EXPECT_LT(KidneyOrgan(anatomy.tumour.points.row(p)), 0.0);
  for (Index p = 0; p < anatomy.internal.points.rows(); ++p)
    EXPECT_LT(KidneyOrgan(anatomy.internal.points.row(p)), -3.0) << "parenchyma around the calyces";
}

TEST(PhantomAnatomy, VerticesLieOnTheImplicitSurface) {
  const PhantomAnatomy anatomy = BuildPhantomAnatomy(Kidney());
  for (Index p = 0; p < anatomy.organ.points.rows(); ++p)
    if (anatomy.organ_cut[p] == 0) {
      EXPECT_NEAR(KidneyOrgan(anatomy.organ.points.row(p)), 0.0, 1e-2);
    }
}

/// With the whole sheets in, the pieces are closed and share every rim point.
TEST(PhantomAnatomy, TheSheetsCloseAllPieces) {
  for (auto scenario : {PhantomScenario::KidneyCut, PhantomScenario::BandCut,
                        PhantomScenario::KidneyTwoCuts, PhantomScenario::BandTwoCuts}) {
    const PhantomSetup setup = MakePhantomSetup(scenario, 1);
    const PhantomAnatomy anatomy = BuildPhantomAnatomy(setup);
    double volume = 0.0;
    for (int region = 0; region <= static_cast<int>(setup.motion.cuts.size()); ++region) {
      std::map<std::array<double, 3>, Index> at;
      std::vector<std::array<Index, 3>> triangles;
      for (Index t = 0; t < anatomy.organ.triangles.rows(); ++t) {
        if (anatomy.organ_region[anatomy.organ.triangles(t, 0)] != region) continue;
        std::array<Index, 3> corners{};
        for (int k = 0; k < 3; ++k) {
          const Vec3 p = anatomy.organ.points.row(anatomy.organ.triangles(t, k));
          corners[k] =
              at.try_emplace({p.x(), p.y(), p.z()}, static_cast<Index>(at.size())).first->second;
        }
        triangles.push_back(corners);
      }
      SurfaceMesh piece;
      piece.points.resize(static_cast<Eigen::Index>(at.size()), 3);
      for (const auto& [p, i] : at) piece.points.row(i) << p[0], p[1], p[2];
      piece.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
      for (std::size_t t = 0; t < triangles.size(); ++t)
        piece.triangles.row(t) << triangles[t][0], triangles[t][1], triangles[t][2];
      EXPECT_TRUE(piece.IsClosedManifold()) << ToString(scenario) << ", region " << region;
      EXPECT_GT(piece.SignedVolume(), 0.0);
      volume += piece.SignedVolume();
    }
    PhantomSetup uncut = setup;
    uncut.motion.cuts.clear();
    EXPECT_NEAR(volume / BuildPhantomAnatomy(uncut).organ.SignedVolume(), 1.0, 2e-3);
  }
}

TEST(PhantomAnatomy, FacesAppearAndTrianglesGoAsTheTipPasses) {
  const PhantomSetup setup = Kidney();
  const PhantomAnatomy anatomy = BuildPhantomAnatomy(setup);
  const PhantomMotion motion(setup.motion);
  Index faces_before = -1;
  for (int frame : {0, 76, 85, 100, 118}) {
    const PhantomSurfaceAtFrame organ = OrganAtFrame(anatomy, motion, frame);
    Index faces = 0;
    for (Index t = 0; t < organ.mesh.triangles.rows(); ++t)
      faces += anatomy.organ_cut[organ.pid[organ.mesh.triangles(t, 0)]] != 0;
    EXPECT_EQ(faces > 0, motion.TipDepth_mm(frame, 0) > 1.0);
    EXPECT_EQ(faces % 2, 0) << "both faces";
    EXPECT_GE(faces, faces_before);
    faces_before = faces;
  }
  const Index whole = anatomy.internal.triangles.rows();
  EXPECT_EQ(StructureAtFrame(anatomy.internal, motion, 76).triangles.rows(), whole);
  const Index cut = StructureAtFrame(anatomy.internal, motion, 149).triangles.rows();
  EXPECT_LT(cut, whole - 20) << "the cut incises the calyces";
  EXPECT_GT(cut, whole * 9 / 10);
  EXPECT_EQ(StructureAtFrame(anatomy.tumour, motion, 149).triangles.rows(),
            anatomy.tumour.triangles.rows())
      << "and leaves the tumour alone";
}

TEST(PhantomAnatomy, FacesOfEachCutAppearAtItsOwnTime) {
  for (auto scenario : {PhantomScenario::KidneyTwoCuts, PhantomScenario::BandTwoCuts}) {
    const PhantomSetup setup = MakePhantomSetup(scenario, 1);
    const PhantomAnatomy anatomy = BuildPhantomAnatomy(setup);
    const PhantomMotion motion(setup.motion);
    for (double frame : {70.0, setup.motion.cuts[1].start_frame, setup.frame_count - 1.0}) {
      const PhantomSurfaceAtFrame organ = OrganAtFrame(anatomy, motion, frame);
      std::array<int, 3> faces{};
      for (Index t = 0; t < organ.mesh.triangles.rows(); ++t)
        ++faces[anatomy.organ_cut[organ.pid[organ.mesh.triangles(t, 0)]]];
      for (int cut = 0; cut < 2; ++cut) {
        EXPECT_EQ(faces[cut + 1] > 0, frame > setup.motion.cuts[cut].start_frame)
            << ToString(scenario) << ", cut " << cut << ", frame " << frame;
        EXPECT_EQ(faces[cut + 1] % 2, 0) << "both faces";
        std::vector<float> depth;
        const SurfaceMesh sheet = OpenedSheet(anatomy, motion, cut, frame, &depth);
        EXPECT_EQ(2 * sheet.triangles.rows(), faces[cut + 1]);
        for (Index p = 0; p < sheet.points.rows(); ++p)
          ASSERT_NEAR(motion.SheetDistance_mm(sheet.points.row(p), cut), 0.0, 1e-9);
      }
    }
  }
}

TEST(PhantomAnatomy, TheCutLineRunsOverTheCameraSide) {
  const PhantomSetup setup = Kidney();
  const PhantomMotion motion(setup.motion);
  const Points line = CutLine(setup, motion, 0, setup.motion.cuts[0].final_depth_mm);
  ASSERT_GT(line.rows(), 20);
  for (Index i = 0; i < line.rows(); ++i) {
    EXPECT_NEAR(KidneyOrgan(line.row(i)), 0.0, 0.02);
    EXPECT_NEAR(motion.SheetDistance_mm(line.row(i), 0), 0.0, 1e-9);
    EXPECT_GT(KidneyOrgan(Vec3(line.row(i)) + Vec3(0, 0, 0.5)), 0.0) << "the camera's side";
  }
  EXPECT_EQ(CutLine(setup, motion, 0, 0.0).rows(), 0);
}

class Ct : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    Progress progress;
    ct_ = new PhantomCt(MakePhantomCt(Kidney(), progress));
  }
  static void TearDownTestSuite() {
    delete ct_;
    ct_ = nullptr;
  }
  /// Mean and standard deviation of voxels whose distance to `f`'s surface is below `limit` mm.
  static std::pair<double, double> Intensity(double (*f)(const Vec3&), double limit, double other) {
    const PhantomSetup setup = Kidney();
    const Eigen::Isometry3d organ_from_world = setup.world_from_organ.inverse();
    const GridGeometry& grid = ct_->ct.grid;
    double sum = 0.0, square = 0.0;
    int n = 0;
    for (int k = 0; k < grid.size[2]; ++k)
      for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i) {
          const Vec3 p = organ_from_world * grid.WorldFromIndex(Vec3(i, j, k));
          if (f(p) > limit) continue;
          if (other > 0.0 && std::min(KidneyTumour(p), KidneyCalyces(p)) < other) continue;
          const double hu = (*ct_->ct.voxels)[grid.Offset(i, j, k)];
          sum += hu;
          square += hu * hu;
          ++n;
        }
    const double mean = sum / n;
    return {mean, std::sqrt(square / n - mean * mean)};
  }
  static PhantomCt* ct_;
};
PhantomCt* Ct::ct_ = nullptr;

TEST_F(Ct, HasTheIntensitiesOfAnExcretoryPhase) {
  const auto parenchyma = Intensity(KidneyOrgan, -3.0, 3.0);
  EXPECT_NEAR(parenchyma.first, 165.0, 8.0);
  EXPECT_GT(parenchyma.second, 10.0) << "there is noise";
  EXPECT_LT(parenchyma.second, 25.0);
  EXPECT_NEAR(Intensity(KidneyTumour, -2.5, -1.0).first, 82.0, 10.0);
  EXPECT_GT(Intensity(KidneyCalyces, -1.8, -1.0).first, 380.0);
}

TEST_F(Ct, LabelsHoldTheAnalyticVolumes) {
  const PhantomAnatomy anatomy = BuildPhantomAnatomy(Kidney(false));
  const double tumour = anatomy.tumour.SignedVolume(), internal = anatomy.internal.SignedVolume();
  const LabelMap& labels = ct_->labels;
  EXPECT_NEAR(labels.LabelVolume_mm3(Label::Tumour) / tumour, 1.0, 0.03);
  EXPECT_NEAR(labels.LabelVolume_mm3(Label::Internal) / internal, 1.0, 0.05);
  EXPECT_NEAR(
      labels.LabelVolume_mm3(Label::Organ) / (anatomy.organ.SignedVolume() - tumour - internal),
      1.0, 0.01);
}

TEST_F(Ct, StandsFreeOfTheBorderWithAnOriginAwayFromZero) {
  const GridGeometry& grid = ct_->labels.grid;
  EXPECT_GT(grid.origin_mm.norm(), 20.0);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        if (i == 0 || j == 0 || k == 0 || i + 1 == grid.size[0] || j + 1 == grid.size[1] ||
            k + 1 == grid.size[2]) {
          ASSERT_EQ((*ct_->labels.voxels)[grid.Offset(i, j, k)], 0);
        }
}

TEST_F(Ct, IsTheSameForASeedAndOtherwiseNot) {
  Progress progress;
  EXPECT_EQ(*MakePhantomCt(Kidney(), progress).ct.voxels, *ct_->ct.voxels);
  PhantomSetup other = Kidney();
  other.seed = 2;
  const PhantomCt second = MakePhantomCt(other, progress);
  EXPECT_NE(*second.ct.voxels, *ct_->ct.voxels);
  EXPECT_EQ(*second.labels.voxels, *ct_->labels.voxels) << "the seed changes noise, not shape";
}

}  // namespace
}  // namespace kerf
