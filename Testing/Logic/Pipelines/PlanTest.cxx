/// What a case folder holds, and that it is read back.
#include <gtest/gtest.h>

#include "Adapters/Itk/Seeds.h"
#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/CaseFolder.h"
#include "Core/Errors.h"
#include "Logic/CaseIO/TemporaryFolder.h"
#include "Pipelines/PlanPipeline.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

/// Sphere of 18 mm with a tumour of 6 mm and an inner tube, on a CT of its own brightness.
void WriteSphere(const testing::TemporaryFolder& folder) {
  Volume ct;
  ct.grid.size = {48, 48, 48};
  ct.grid.spacing_mm = {1, 1, 1};
  ct.grid.origin_mm = Vec3(30, -40, 100);
  LabelMap labels;
  labels.grid = ct.grid;
  const Vec3 center = ct.grid.WorldFromIndex(Vec3::Constant(23.5));
  auto hu = std::make_shared<std::vector<std::int16_t>>(ct.grid.VoxelCount(), -90);
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(ct.grid.VoxelCount(), 0);
  for (int k = 0; k < 48; ++k)
    for (int j = 0; j < 48; ++j)
      for (int i = 0; i < 48; ++i) {
        const Vec3 p = ct.grid.WorldFromIndex(Vec3(i, j, k)) - center;
        if (p.norm() > 18) continue;
        const bool tumour = (p - Vec3(8, 0, 0)).norm() < 6;
        const bool tube = p.tail<2>().norm() < 2.5 && p.x() < 0 && p.x() > -12;
        const std::size_t at = ct.grid.Offset(i, j, k);
        (*voxels)[at] = tumour ? 2 : tube ? 3 : 1;
        (*hu)[at] = tumour ? 60 : tube ? 500 : 150;
      }
  ct.voxels = hu;
  labels.voxels = voxels;
  WriteVolume(folder / "ct.nii.gz", ct);
  WriteLabelMap(folder / "labels.nii.gz", labels);
}

class PlanTest : public ::testing::Test {
 protected:
  PlanTest() {
    WriteSphere(folder_);
    request_.input = folder_ / "ct.nii.gz";
    request_.meshing.tetrahedra = 2000;
  }
  testing::TemporaryFolder folder_;
  PlanRequest request_;
  Progress silent_;
};

TEST_F(PlanTest, ACaseHoldsWhatTheOperatingRoomNeeds) {
  request_.labels_file = folder_ / "labels.nii.gz";
  request_.landmarks_file =
      folder_.Write("landmarks.csv", "id,x_mm,y_mm,z_mm,u_px,v_px\n4,-50,20,120,10,20\n");
  const CameraModel camera = testing::Pinhole(640, 480, 600, Vec3(1, 2, 300));
  request_.camera_file = folder_ / "camera.yml";
  WriteCameraFile(request_.camera_file, camera);
  const PlannedCase planned = Plan(request_, silent_);
  WriteCase(planned, folder_ / "case");

  const CaseFolder opened = CaseFolder::Open(folder_ / "case");
  for (const char* role : {"ct", "segmentation", "organ_mesh", "organ_surface", "internal",
                           "tumour", "landmarks", "camera"})
    EXPECT_TRUE(opened.Has(role)) << role;
  EXPECT_EQ(opened.Manifest().provenance.at("input_sha256").size(), 64u);
  EXPECT_EQ(opened.Manifest().provenance.at("labels_sha256").size(), 64u);
  EXPECT_EQ(ReadSegmentation(opened.Path("segmentation")).names.at(3), "internal");
  EXPECT_TRUE(ReadVolume(opened.Path("ct")).grid.SameAs(planned.ct->grid));
  EXPECT_TRUE(ReadCameraFile(opened.Path("camera"))
                  .camera_from_world.isApprox(camera.camera_from_world, 1e-12));
  const auto landmarks = ReadMarkups(opened.Path("landmarks"));
  ASSERT_EQ(landmarks.size(), 1u);
  ASSERT_EQ(landmarks[0].points.size(), 1u);
  EXPECT_EQ(landmarks[0].points[0].label, "landmark-4");
  EXPECT_EQ(landmarks[0].points[0].position_mm, Vec3(50, -20, 120)) << "the study's file is RAS";

  const PlannedCase back = ReadCase(folder_ / "case");
  EXPECT_EQ(back.mesh.TetCount(), planned.mesh.TetCount());
  EXPECT_EQ(back.structures.size(), 2u);
  EXPECT_EQ(back.landmarks.size(), 1u);
  ASSERT_TRUE(back.camera);
  EXPECT_EQ(back.camera->width, 640);
}

TEST_F(PlanTest, TheSeedsStayWithTheCase) {
  request_.preset = "kidney";
  request_.seeds_file = folder_ / "seeds.mrk.json";
  WriteMarkups(request_.seeds_file, {{"Fiducial", {{"organ-1", Vec3(44, -17, 123)}}}});
  const PlannedCase planned = Plan(request_, silent_);
  WriteCase(planned, folder_ / "case");
  const CaseFolder opened = CaseFolder::Open(folder_ / "case");
  ASSERT_EQ(opened.Paths("plan").size(), 1u);
  const auto seeds = ReadSeeds(opened.Path("plan"));
  ASSERT_EQ(seeds.size(), 1u);
  EXPECT_EQ(seeds[0].position_mm, Vec3(44, -17, 123));
  EXPECT_EQ(opened.Manifest().provenance.at("preset"), "kidney");
}

TEST_F(PlanTest, ACalibrationNeedsNoPose) {
  request_.labels_file = folder_ / "labels.nii.gz";
  request_.camera_file = folder_.Write(
      "camera.yml",
      "%YAML:1.0\n---\nimage_width: 64\nimage_height: 48\ncamera_matrix: !!opencv-matrix\n"
      "   rows: 3\n   cols: 3\n   dt: d\n   data: [ 60., 0., 31.5, 0., 60., 23.5, 0., 0., 1. ]\n");
  EXPECT_EQ(Plan(request_, silent_).camera->width, 64);
  request_.camera_file = folder_ / "none.yml";
  EXPECT_THROW(Plan(request_, silent_), InputError);
}

TEST_F(PlanTest, ASurfaceGivesACaseWithoutInnerStructures) {
  WriteSurface(testing::SphereSurface({10, -20, 30}, 20, 3), folder_ / "ball.stl");
  request_.input = folder_ / "ball.stl";
  WriteCase(Plan(request_, silent_), folder_ / "case");
  const CaseFolder opened = CaseFolder::Open(folder_ / "case");
  EXPECT_TRUE(opened.Has("organ_mesh"));
  for (const char* role : {"ct", "segmentation", "internal", "tumour", "landmarks", "camera"})
    EXPECT_FALSE(opened.Has(role)) << role;
}

TEST_F(PlanTest, OptionsThatContradictEachOtherAreWrongUse) {
  request_.labels_file = folder_ / "labels.nii.gz";
  request_.preset = "liver";
  EXPECT_THROW(Plan(request_, silent_), UsageError);
  request_.preset.clear();
  request_.series_uid = "1.2.3";
  EXPECT_THROW(Plan(request_, silent_), UsageError);
}

}  // namespace
}  // namespace kerf
