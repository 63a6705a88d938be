/// kerf evaluate --reference-labels: final meshes against the label map of a second CT.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "Core/Errors.h"
#include "Logic/CaseIO/TemporaryFolder.h"
#include "Pipelines/EvaluatePipeline.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using testing::MessageOf;
using testing::TemporaryFolder;

/// Sphere of 20 mm with a tumour of 6 mm at (5, 0, 0), seen by a CT whose patient lies elsewhere.
LabelMap SecondCt(const Vec3& shift) {
  LabelMap labels;
  labels.grid.size = {60, 60, 60};
  labels.grid.spacing_mm = {0.8, 0.8, 0.8};
  labels.grid.origin_mm = shift - Vec3::Constant(0.8 * 29.5);
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(labels.grid.VoxelCount(), 0);
  for (int k = 0; k < 60; ++k)
    for (int j = 0; j < 60; ++j)
      for (int i = 0; i < 60; ++i) {
        const Vec3 p = labels.grid.WorldFromIndex(Vec3(i, j, k)) - shift;
        if (p.norm() < 20)
          (*voxels)[labels.grid.Offset(i, j, k)] = (p - Vec3(5, 0, 0)).norm() < 6 ? 2 : 1;
      }
  labels.voxels = std::move(voxels);
  return labels;
}

class ReferenceLabels : public ::testing::Test {
 protected:
  void SetUp() override {
    TetMesh mesh = testing::SphereMesh(20.0, 8);
    testing::PaintSphere(Vec3(5, 0, 0), 6.0, Label::Tumour, &mesh);
    WriteTetMesh(mesh, mesh.rest, folder_ / "organ_final.vtu");
    WriteSurface(testing::SphereSurface(Vec3(5, 0, 0), 6.0, 4), folder_ / "tumour_final.vtp");
  }
  TemporaryFolder folder_;
  Progress silent_;
};

TEST_F(ReferenceLabels, AMatchingCtMatches) {
  WriteLabelMap(folder_ / "after.nrrd", SecondCt(Vec3::Zero()));
  const auto scores = EvaluateAgainstLabels(folder_.Path(), folder_ / "after.nrrd", "", silent_);
  ASSERT_TRUE(scores.distance.count("organ"));
  EXPECT_LT(scores.distance.at("organ").mean_mm, 0.25);
  EXPECT_LT(scores.distance.at("tumour").mean_mm, 0.2);
  EXPECT_GT(scores.volume_dice.at("organ"), 0.97);
  EXPECT_GT(scores.volume_dice.at("tumour"), 0.8) << "whole tetrahedra are a coarse tumour";
  EXPECT_FALSE(scores.distance.count("internal")) << "neither side has one";
  const auto json = nlohmann::json::parse(MetricsText(nullptr, &scores));
  EXPECT_GT(json["reference"]["organ"]["volume_dice"].get<double>(), 0.97);
  EXPECT_THAT(ReferenceTable(scores), HasSubstr("tumour"));
}

TEST_F(ReferenceLabels, TheTransformMovesTheSecondCtOntoTheCase) {
  const Vec3 shift(30, -12, 7);
  WriteLabelMap(folder_ / "after.nrrd", SecondCt(shift));
  const auto off = EvaluateAgainstLabels(folder_.Path(), folder_ / "after.nrrd", "", silent_);
  EXPECT_GT(off.distance.at("organ").mean_mm, 5.0);
  EXPECT_LT(off.volume_dice.at("organ"), 0.3);
  const auto matrix = folder_.Write("t.txt", "1 0 0 -30\n0 1 0 12\n0 0 1 -7\n0 0 0 1\n");
  const auto on = EvaluateAgainstLabels(folder_.Path(), folder_ / "after.nrrd", matrix, silent_);
  EXPECT_LT(on.distance.at("organ").mean_mm, 0.25);
  EXPECT_GT(on.volume_dice.at("organ"), 0.97);
}

TEST_F(ReferenceLabels, NamesWhatIsMissing) {
  LabelMap empty = SecondCt(Vec3(1000, 0, 0));
  empty.voxels = std::make_shared<std::vector<std::uint8_t>>(empty.grid.VoxelCount(), 0);
  WriteLabelMap(folder_ / "empty.nrrd", empty);
  EXPECT_THAT(MessageOf<InputError>([&] {
                EvaluateAgainstLabels(folder_.Path(), folder_ / "empty.nrrd", "", silent_);
              }),
              HasSubstr("empty.nrrd"));
  EXPECT_THAT(MessageOf<InputError>([&] {
                EvaluateAgainstLabels(folder_.Path(), folder_ / "none.nrrd", "", silent_);
              }),
              HasSubstr("none.nrrd"));
}

}  // namespace
}  // namespace kerf
