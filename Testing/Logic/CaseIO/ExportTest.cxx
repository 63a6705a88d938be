/// kerf export: every format in both spaces is read back and is the same thing at the same place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/CaseFolder.h"
#include "Core/Errors.h"
#include "Pipelines/ExportPipeline.h"
#include "Support/TestMeshes.h"
#include "TemporaryFolder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::MessageOf;
using testing::TemporaryFolder;

LabelMap BoxLabels() {
  LabelMap labels;
  labels.grid.size = {24, 20, 16};
  labels.grid.spacing_mm = {1.5, 1.25, 2.0};
  labels.grid.origin_mm = {-17.25, -11.875, -15.0};
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(labels.grid.VoxelCount(), 0);
  for (int k = 0; k < 16; ++k)
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 24; ++i) {
        const Vec3 p = labels.grid.WorldFromIndex(Vec3(i, j, k));
        if (std::abs(p.x()) > 15 || std::abs(p.y()) > 10 || std::abs(p.z()) > 5) continue;
        (*voxels)[labels.grid.Offset(i, j, k)] = p.x() > 8 ? 2 : std::abs(p.y()) < 2 ? 3 : 1;
      }
  labels.voxels = std::move(voxels);
  labels.names = {{1, "organ"}, {2, "tumour"}, {3, "internal"}};
  return labels;
}

/// The 30 × 20 × 10 mm box with a sphere in it, moved and bent where `deformed`.
Points Bent(const Points& rest) {
  Points p = rest;
  for (Index i = 0; i < p.rows(); ++i) p(i, 2) += 0.01 * rest(i, 0) * rest(i, 0) + 7.0;
  return p;
}

class ExportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    mesh_ = testing::BoxMesh({30, 20, 10}, 9, 6, 3);
    sphere_ = testing::SphereSurface(Vec3(2, -1, 0.5), 3.0, 3);
    CaseWriter writer(folder_ / "case");
    WriteTetMesh(mesh_, mesh_.rest, writer.Stage("organ.vtu", "organ_mesh"));
    WriteSurface(BoundarySurface(mesh_, mesh_.rest), writer.Stage("organ.vtp", "organ_surface"));
    WriteSurface(sphere_, writer.Stage("tumour.vtp", "tumour"));
    WriteSegmentation(writer.Stage("segmentation.seg.nrrd", "segmentation"), BoxLabels());
    writer.Commit();
    fs::create_directories(folder_ / "results/case");
    fs::copy(folder_ / "case/segmentation.seg.nrrd",
             folder_ / "results/case/segmentation.seg.nrrd");
    WriteTetMesh(mesh_, Bent(mesh_.rest), folder_ / "results/organ_final.vtu");
    WriteSurface(sphere_, folder_ / "results/tumour_final.vtp");
    WriteSurface(sphere_, folder_ / "results/cut_0_surface.vtp");
  }
  /// The bent organ, as a session or a replay leaves it; without a planned map of its own.
  void WriteResults(const std::string& folder) {
    WriteTetMesh(mesh_, Bent(mesh_.rest), folder_ / (folder + "/organ_final.vtu"));
  }
  LabelMap ExportedLabels(const std::string& input) {
    Run(input, "seg.nrrd", false);
    return ReadLabelMap(folder_ / "out/segmentation_final.seg.nrrd");
  }
  std::vector<std::string> Run(const std::string& input, const std::string& format, bool ras) {
    Progress silent;
    return Export({folder_ / input, format, ras, folder_ / "out"}, silent);
  }
  static void ExpectSame(const SurfaceMesh& a, const SurfaceMesh& b) {
    // .stl has no points: they are merged in another order.
    ASSERT_EQ(a.triangles.rows(), b.triangles.rows());
    EXPECT_NEAR(a.SignedVolume(), b.SignedVolume(), 1e-3 * std::abs(b.SignedVolume()));
    EXPECT_LT((a.points.colwise().mean() - b.points.colwise().mean()).norm(), 1e-3);
    EXPECT_LT((a.points.colwise().maxCoeff() - b.points.colwise().maxCoeff()).norm(), 1e-3);
    EXPECT_TRUE(a.IsClosedManifold());
  }

  TemporaryFolder folder_;
  TetMesh mesh_;
  SurfaceMesh sphere_;
};

TEST_F(ExportTest, SurfacesComeBackFromEveryFormatInBothSpaces) {
  for (const char* format : {"vtp", "stl", "ply", "obj"})
    for (const bool ras : {false, true}) {
      SCOPED_TRACE(std::string(format) + (ras ? " RAS" : " LPS"));
      const auto files = Run("case", format, ras);
      ASSERT_EQ(files.size(), 2u);
      const SurfaceFile tumour = ReadSurfaceFile(folder_ / (std::string("out/tumour.") + format));
      EXPECT_EQ(tumour.space, ras ? Space::RAS : Space::LPS) << "the file does not say its space";
      ExpectSame(tumour.surface, sphere_);
      ExpectSame(ReadSurface(folder_ / (std::string("out/organ.") + format)),
                 BoundarySurface(mesh_, mesh_.rest));
    }
}

TEST_F(ExportTest, ResultsAreExportedAsTheyAreInTheEnd) {
  const auto files = Run("results", "vtp", true);
  ASSERT_EQ(files.size(), 3u);
  const SurfaceFile organ = ReadSurfaceFile(folder_ / "out/organ_final.vtp");
  ExpectSame(organ.surface, BoundarySurface(mesh_, Bent(mesh_.rest)));
  ASSERT_TRUE(organ.rest_position.has_value());
  EXPECT_LT((organ.rest_position->colwise().minCoeff() - Eigen::RowVector3d(-15, -10, -5)).norm(),
            1e-4);
  EXPECT_TRUE(fs::exists(folder_ / "out/cut_0_surface.vtp"));
  Points positions;
  Run("results", "vtu", true);
  const TetMesh back = ReadTetMesh(folder_ / "out/organ_final.vtu", &positions);
  EXPECT_LT((back.rest - mesh_.rest).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT((positions - Bent(mesh_.rest)).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_EQ(back.region, mesh_.region);
}

TEST_F(ExportTest, GlbIsWritten) {
  Run("case", "glb", false);
  EXPECT_EQ(folder_.Read("out/organ.glb").substr(0, 4), "glTF");
}

TEST_F(ExportTest, LabelsAreTheSameInBothSpaces) {
  Run("case", "seg.nrrd", false);
  const LabelMap lps = ReadLabelMap(folder_ / "out/segmentation.seg.nrrd");
  Run("case", "seg.nrrd", true);
  EXPECT_THAT(folder_.Read("out/segmentation.seg.nrrd").substr(0, 600),
              HasSubstr("space: right-anterior-superior"));
  const LabelMap ras = ReadLabelMap(folder_ / "out/segmentation.seg.nrrd");
  EXPECT_EQ(*lps.voxels, *BoxLabels().voxels);
  // ITK may hold the same grid with flipped axes: compare places, not indices.
  const GridGeometry original = BoxLabels().grid;
  for (int k = 0; k < 16; k += 3)
    for (int j = 0; j < 20; j += 3)
      for (int i = 0; i < 24; i += 3) {
        const Vec3 index = ras.grid.IndexFromWorld(original.WorldFromIndex(Vec3(i, j, k)));
        ASSERT_LT((index - Vec3(index.array().round())).norm(), 1e-6);
        EXPECT_EQ((*ras.voxels)[ras.grid.Offset(std::lround(index[0]), std::lround(index[1]),
                                                std::lround(index[2]))],
                  (*lps.voxels)[original.Offset(i, j, k)]);
      }
}

TEST_F(ExportTest, LabelsMoveWithTheOrgan) {
  Run("results", "seg.nrrd", false);
  const LabelMap moved = ReadLabelMap(folder_ / "out/segmentation_final.seg.nrrd");
  auto at = [&](const Vec3& p) {
    const Vec3 i = moved.grid.IndexFromWorld(p);
    return (
        *moved.voxels)[moved.grid.Offset(std::lround(i[0]), std::lround(i[1]), std::lround(i[2]))];
  };
  // Rest (12, 6, 0) is tumour and lies at z = 1.44 + 7 now; (-3, 6, 0) organ; (0, 0, 0) inner
  // structure.
  EXPECT_EQ(at({12, 6, 8.4}), 2);
  EXPECT_EQ(at({-3, 6, 7.1}), 1);
  EXPECT_EQ(at({0, 0, 7.0}), 3);
  EXPECT_EQ(at({0, 0, -1.0}), 0) << "nothing is left where the organ was";
  EXPECT_NEAR(moved.LabelVolume_mm3(Label::Organ) + moved.LabelVolume_mm3(Label::Tumour) +
                  moved.LabelVolume_mm3(Label::Internal),
              6000.0, 250.0);
}

/// The planned map's name is the manifest's to choose.
void NameTheLabels(const std::string& case_folder, const std::string& name) {
  CaseWriter writer = CaseWriter::Update(case_folder);
  writer.Remove("segmentation.seg.nrrd");
  WriteSegmentation(writer.Stage(name, "segmentation"), BoxLabels());
  writer.Commit();
}

TEST_F(ExportTest, LabelsOfASessionAreOnItsCasesGrid) {
  NameTheLabels(folder_ / "case", "labels/planned.seg.nrrd");
  WriteResults("case/sessions/2026-01-01");
  folder_.Write("case/sessions/2026-01-01/session.json", "{}");
  for (const char* input : {"case/sessions/2026-01-01", "case/sessions/2026-01-01/"}) {
    const LabelMap labels = ExportedLabels(input);
    EXPECT_EQ(labels.grid.spacing_mm, BoxLabels().grid.spacing_mm) << input;
    EXPECT_GT(labels.LabelVolume_mm3(Label::Internal), 0) << input;
    EXPECT_GT(labels.LabelVolume_mm3(Label::Tumour), 0) << input;
  }
}

TEST_F(ExportTest, LabelsOfResultsThatLieInAnotherCaseAreNotThatCases) {
  WriteResults("case/results/x");  // kerf replay --case other --output case/results/x
  folder_.Write("case/elsewhere/y/session.json", "{}");
  WriteResults("case/elsewhere/y");
  WriteResults("case/sessions/no-session");
  for (const char* input : {"case/results/x", "case/elsewhere/y", "case/sessions/no-session"}) {
    const LabelMap labels = ExportedLabels(input);
    EXPECT_EQ(labels.grid.spacing_mm, Vec3(Vec3::Ones())) << input;
    EXPECT_EQ(labels.LabelVolume_mm3(Label::Internal), 0) << input;
    EXPECT_EQ(labels.LabelVolume_mm3(Label::Tumour), 0) << input;
  }
}

/// Where results belong to no case, none is looked for where the shell happens to stand.
TEST_F(ExportTest, LabelsOfResultsWithoutACaseAreNotThoseOfTheCurrentFolder) {
  WriteResults("alone");
  const fs::path stood = fs::current_path();
  fs::current_path(folder_ / "case");  // another patient's
  LabelMap labels;
  EXPECT_NO_THROW(labels = ExportedLabels("alone"));
  fs::current_path(stood);
  ASSERT_TRUE(labels.voxels);
  EXPECT_EQ(labels.grid.spacing_mm, Vec3(Vec3::Ones()));
  EXPECT_EQ(labels.LabelVolume_mm3(Label::Tumour), 0);
}

TEST_F(ExportTest, WhatCannotBeExportedIsNamed) {
  EXPECT_THAT(MessageOf<UsageError>([&] { Run("case", "dxf", false); }), HasSubstr("dxf"));
  EXPECT_THAT(MessageOf<InputError>([&] { Run("none", "stl", false); }), HasSubstr("no folder"));
  folder_.Write("study/case.json", R"({"format": "kerf-study"})");
  EXPECT_THAT(MessageOf<InputError>([&] { Run("study", "stl", false); }),
              HasSubstr("neither a case folder"));
  folder_.Write("case/organ.vtu", "damaged");
  EXPECT_THAT(MessageOf<InputError>([&] { Run("case", "vtu", false); }), HasSubstr("organ.vtu"));
}

}  // namespace
}  // namespace kerf
