// What the segmentation says about its own result: each sentence, and the result without it.
#include <gtest/gtest.h>

#include "Adapters/Itk/SegmentationCheck.h"
#include "Adapters/Itk/WorkingGrid.h"
#include "TestSupport.h"

namespace kerf {
namespace {

using testing::Says;

/// A ball of 120 HU on a crop of a CT of 64³ voxels, with nothing inside.
class SegmentationCheck : public ::testing::Test {
 protected:
  /// @param radius of the ball, voxels; @param spacing_mm 1.5 makes 20 voxels 113 ml
  void Make(double radius, double spacing_mm = 1.5) {
    ct_.grid.size = Eigen::Vector3i::Constant(64);
    ct_.grid.spacing_mm = Vec3::Constant(spacing_mm);
    ct_.grid.direction = Eigen::AngleAxisd(0.4, Vec3::UnitZ()).toRotationMatrix();
    ct_.voxels = std::make_shared<std::vector<std::int16_t>>(ct_.grid.VoxelCount(), -90);
    const GridGeometry crop = CropGrid(ct_.grid, {11, 0, 11}, {63, 63, 61});
    region_.mask = Mask(crop, 0);
    region_.alike = Mask(crop, 0);
    inner_ = {Mask(crop, 0), Mask(crop, 0), Mask(crop, 0)};
    Set(Vec3(32, 32, 32), radius, &region_.mask);
    auto hu = std::make_shared<std::vector<std::int16_t>>(*ct_.voxels);
    for (int k = 0; k < 64; ++k)
      for (int j = 0; j < 64; ++j)
        for (int i = 0; i < 64; ++i)
          if ((Vec3(i, j, k) - Vec3(32, 32, 32)).norm() < radius)
            (*hu)[ct_.grid.Offset(i, j, k)] = 120;
    ct_.voxels = hu;
  }
  /// @param center in voxels of the CT
  void Set(const Vec3& center, double radius, Mask* mask, std::uint8_t value = 1) const {
    const Vec3 first = ct_.grid.IndexFromWorld(mask->grid.origin_mm);
    for (int k = 0; k < mask->grid.size[2]; ++k)
      for (int j = 0; j < mask->grid.size[1]; ++j)
        for (int i = 0; i < mask->grid.size[0]; ++i)
          if ((first + Vec3(i, j, k) - center).norm() < radius)
            mask->values[mask->grid.Offset(i, j, k)] = value;
  }
  const SegmentationReport& Check() {
    report_ = SegmentationReport();
    CheckSegmentation(ct_, KnowledgeOf(OrganPreset::Kidney), region_, inner_, &report_);
    return report_;
  }
  /// The one warning that is made.
  std::string Warning() {
    Check();
    EXPECT_EQ(report_.warnings.size(), 1u);
    return report_.warnings.empty() ? "" : report_.warnings.front();
  }
  Volume ct_;
  OrganRegion region_;
  InnerStructures inner_;
  SegmentationReport report_;
};

TEST_F(SegmentationCheck, SaysNothingOfWhatIsWell) {
  Make(20);
  Set(Vec3(38, 32, 32), 6, &inner_.tumour);
  EXPECT_TRUE(Check().warnings.empty()) << report_.warnings.front();
  EXPECT_TRUE(report_.plausible);
  EXPECT_EQ(report_.preset, "kidney");
  EXPECT_NEAR(report_.organ_ml, 113.1, 1);
  EXPECT_NEAR(report_.tumour_ml, 3.05, 0.2);
  EXPECT_EQ(report_.organ_mean_hu, 120) << "the crop's offset counts";
  EXPECT_EQ(report_.components, 1);
  EXPECT_EQ(report_.holes, 0);
  EXPECT_EQ(report_.open_surface, 0);
  EXPECT_FALSE(report_.touches_border);
}

TEST_F(SegmentationCheck, AnImplausibleVolume) {
  Make(12);
  EXPECT_TRUE(Says(Warning(), "24 ml, plausible are 30 to 700 ml: part of it may be missing"));
  EXPECT_FALSE(report_.plausible);
  Make(20, 3);
  EXPECT_TRUE(Says(Warning(), "ml, plausible are 30 to 700 ml: it may have leaked"));
  EXPECT_FALSE(report_.plausible);
  for (const double within : {1.0, 2.7}) {
    Make(20, within);
    EXPECT_TRUE(Check().plausible) << report_.organ_ml;
    EXPECT_TRUE(report_.warnings.empty());
  }
}

TEST_F(SegmentationCheck, SeveralPieces) {
  Make(17);
  Set(Vec3(56, 52, 52), 3, &region_.mask);
  EXPECT_TRUE(Says(Warning(), "the organ has 2 pieces"));
  EXPECT_EQ(report_.components, 2);
  // Faces connect, corners do not.
  Make(17);
  const Vec3 first = ct_.grid.IndexFromWorld(region_.mask.grid.origin_mm);
  const auto set = [&](int i, int j, int k) {
    region_.mask
        .values[region_.mask.grid.Offset(i - int(first[0]), j - int(first[1]), k - int(first[2]))] =
        1;
  };
  set(32, 32, 49);
  EXPECT_TRUE(Check().warnings.empty());
  set(33, 33, 50);
  EXPECT_TRUE(Says(Warning(), "2 pieces"));
}

TEST_F(SegmentationCheck, Holes) {
  Make(20);
  Set(Vec3(32, 32, 32), 3, &region_.mask, 0);
  EXPECT_TRUE(Says(Warning(), "the organ has 1 hole"));
  EXPECT_EQ(report_.holes, 1);
  Set(Vec3(32, 42, 32), 3, &region_.mask, 0);
  EXPECT_TRUE(Says(Warning(), "the organ has 2 holes"));
  // Open to the outside, it is a bay.
  Make(20);
  for (double at = 32; at < 60; ++at) Set(Vec3(32, at, 32), 3, &region_.mask, 0);
  EXPECT_TRUE(Check().warnings.empty()) << report_.warnings.front();
  // What is labelled inside is none.
  Make(20);
  Set(Vec3(32, 32, 32), 3, &inner_.internal);
  EXPECT_TRUE(Check().warnings.empty()) << report_.warnings.front();
}

TEST_F(SegmentationCheck, AnOrganThatIsCutOff) {
  for (const bool cut : {false, true}) {
    Make(17);
    // In j the crop reaches the CT's border: from voxel 1, and from voxel 0.
    Set(Vec3(32, cut ? 16 : 17, 32), 17, &region_.mask);
    Check();
    EXPECT_EQ(report_.touches_border, cut);
    ASSERT_EQ(report_.warnings.size(), cut ? 1u : 0u);
    if (cut) {
      EXPECT_TRUE(Says(report_.warnings.front(), "reaches the volume's border"));
    }
  }
  // The crop's own border is not the CT's.
  Make(17);
  Set(Vec3(28, 32, 32), 17.5, &region_.mask);
  EXPECT_TRUE(Check().warnings.empty()) << report_.warnings.front();
}

TEST_F(SegmentationCheck, TissueAsBrightOutside) {
  Make(20);
  region_.alike = region_.mask;
  EXPECT_TRUE(Check().warnings.empty()) << "itself";
  Set(Vec3(46, 46, 32), 4, &region_.alike);
  EXPECT_TRUE(Check().warnings.empty()) << report_.warnings.front();
  EXPECT_GT(report_.open_surface, 0);
  Set(Vec3(50, 50, 32), 18, &region_.alike);
  EXPECT_TRUE(Says(Warning(), "of the kidney's surface lies tissue of its own brightness"));
  EXPECT_GT(report_.open_surface, 0.1);
}

TEST_F(SegmentationCheck, AnOrganOfLittleButTumourAndVessels) {
  Make(20);
  Set(Vec3(32, 32, 32), 16, &inner_.tumour);  // 51 %
  EXPECT_TRUE(Check().warnings.empty()) << report_.warnings.front();
  Set(Vec3(32, 32, 32), 16, &inner_.tumour, 0);
  Set(Vec3(32, 32, 32), 15, &inner_.tumour);  // 42 %, and more than 18 %
  Set(Vec3(32, 32, 42), 18, &inner_.internal);
  for (std::size_t i = 0; i < region_.mask.values.size(); ++i)
    inner_.internal.values[i] =
        inner_.internal.values[i] && region_.mask.values[i] && !inner_.tumour.values[i];
  EXPECT_TRUE(Says(Warning(), "fill more than half of the organ")) << report_.internal_ml;
  EXPECT_FALSE(report_.plausible);
}

TEST_F(SegmentationCheck, WhatWasLeftOutAndTheSeedsInIt) {
  Make(17);
  const Mask kept = region_.mask;
  Mask found = kept;
  const auto seed = [&](SeedKind kind, double i, const char* id) {
    return Seed{kind, ct_.grid.WorldFromIndex(Vec3(i, 32, 32)), id};
  };
  const std::vector<Seed> seeds = {seed(SeedKind::Organ, 32, "in"),
                                   seed(SeedKind::Background, 56, "background"),
                                   seed(SeedKind::Tumour, 56, "apart")};
  const auto check = [&](std::size_t count) {
    report_ = SegmentationReport();
    CheckLeftOut(found, kept, KnowledgeOf(OrganPreset::Kidney), {seeds[0], seeds[1]}, &report_);
    EXPECT_EQ(report_.warnings.size(), count);
  };
  check(0);
  Set(Vec3(56, 32, 32), 2, &found);  // 0.1 ml
  check(0);
  EXPECT_GT(report_.left_out_ml, 0);
  Set(Vec3(56, 32, 32), 4, &found);
  check(1);
  EXPECT_TRUE(Says(report_.warnings.at(0), "0.8 ml that do not touch the organ were left out"));
  CheckLeftOut(kept, kept, KnowledgeOf(OrganPreset::Kidney), seeds, &report_);
  EXPECT_TRUE(Says(report_.warnings.back(), "the seed apart lies outside"));
  EXPECT_EQ(report_.warnings.size(), 2u);
}

/// A rib between the organ and what lies behind it: with the rib, the piece behind comes off.
TEST_F(SegmentationCheck, WhatComesOffWithARibIsNotLost) {
  Make(15);
  const Vec3 rib(51, 32, 32), behind(59, 32, 32);
  auto hu = std::make_shared<std::vector<std::int16_t>>(*ct_.voxels);
  for (int k = 0; k < 64; ++k)
    for (int j = 0; j < 64; ++j)
      for (int i = 0; i < 64; ++i) {
        if ((Vec3(i, j, k) - behind).norm() < 4) (*hu)[ct_.grid.Offset(i, j, k)] = 120;
        if ((Vec3(i, j, k) - rib).norm() < 6) (*hu)[ct_.grid.Offset(i, j, k)] = 600;
      }
  ct_.voxels = hu;
  Set(behind, 4, &region_.mask);
  Set(rib, 6, &region_.mask);
  testing::Listener heard;
  const InnerStructures found =
      FindInnerStructures(ct_, KnowledgeOf(OrganPreset::Kidney), {120, 80, 160},
                          ScalarField(region_.mask.grid, 0.f), {}, {}, &region_.mask, heard);
  const auto at = [&](const Mask& mask, const Vec3& center) {
    const Eigen::Vector3i v = NearestIndex(mask.grid, ct_.grid.WorldFromIndex(center));
    return int(mask.values[mask.grid.Offset(v[0], v[1], v[2])]);
  };
  EXPECT_EQ(at(region_.mask, Vec3(32, 32, 32)), 1);
  EXPECT_EQ(at(region_.mask, rib), 0);
  EXPECT_EQ(at(region_.mask, behind), 0);
  EXPECT_EQ(at(found.apart, behind + Vec3(1, 0, 0)), 1);
  EXPECT_EQ(at(found.apart, rib), 0) << "a rib is no piece of the organ";
  EXPECT_EQ(at(found.apart, Vec3(32, 32, 32)), 0);
}

}  // namespace
}  // namespace kerf
