#include <gtest/gtest.h>

#include "Core/Errors.h"
#include "Core/Features.h"
#include "Core/Progress.h"
#include "Core/Volume.h"

namespace kerf {
namespace {

TEST(Errors, AnInputErrorNamesFileAndElement) {
  const InputError error("ct.nii.gz", "spacing", "must be positive");
  EXPECT_STREQ(error.what(), "ct.nii.gz: spacing: must be positive");
  EXPECT_EQ(error.File(), "ct.nii.gz");
  EXPECT_EQ(error.Element(), "spacing");
  EXPECT_STREQ(InputError("a", "", "is missing").what(), "a: is missing");
}

class Recorder : public Progress {
 public:
  void Report(double fraction, const std::string& what) override { last = fraction; }
  void Warn(const std::string& message) override { warning = message; }
  bool IsCancelled() const override { return cancelled; }
  double last = -1;
  std::string warning;
  bool cancelled = false;
};

TEST(Progress, APartMapsIntoTheWhole) {
  Recorder whole;
  SubProgress part(whole, 0.2, 0.6);
  part.Report(0.5, "x");
  EXPECT_DOUBLE_EQ(whole.last, 0.4);
  part.Warn("careful");
  EXPECT_EQ(whole.warning, "careful");
  EXPECT_NO_THROW(part.ThrowIfCancelled());
  whole.cancelled = true;
  EXPECT_THROW(part.ThrowIfCancelled(), Cancelled);
}

TEST(Features, StatesHaveTheContractedNames) {
  EXPECT_STREQ(ToString(FeatureStatus::Tracked), "tracked");
  EXPECT_STREQ(ToString(FeatureStatus::Lost), "lost");
  EXPECT_STREQ(ToString(FeatureStatus::Rejected), "rejected");
  EXPECT_STREQ(ToString(FeatureStatus::Occluded), "occluded");
}

TEST(GridGeometry, ObliqueGridsGoToTheWorldAndBack) {
  GridGeometry grid;
  grid.size = {4, 5, 6};
  grid.spacing_mm = {0.7, 0.9, 2.5};
  grid.origin_mm = {-10, 20, 300};
  grid.direction = Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Vec3 index(1.5, 2.25, 4);
  EXPECT_LT((grid.IndexFromWorld(grid.WorldFromIndex(index)) - index).norm(), 1e-12);
  EXPECT_EQ(grid.WorldFromIndex(Vec3::Zero()), grid.origin_mm);
  EXPECT_EQ(grid.VoxelCount(), 120u);
  EXPECT_NEAR(grid.VoxelVolume_mm3(), 0.7 * 0.9 * 2.5, 1e-12);
  EXPECT_NO_THROW(grid.Validate("ct"));
  grid.spacing_mm[1] = std::nan("");
  EXPECT_THROW(grid.Validate("ct"), InputError);
}

}  // namespace
}  // namespace kerf
