/// Segmentation of real CTs and of the studies' CTs against their labels. KERF_SEEDS=20 makes the
/// spread over seeds that docs/reference/segmentation.md tells of; by default one is tried.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <queue>
#include <random>

#include "Adapters/Itk/Segmentation.h"
#include "Adapters/Itk/VolumeFiles.h"
#include "Overlap.h"
#include "Support/CasesFolder.h"
#include "TestSupport.h"

namespace kerf {
namespace {

using testing::Dice;
using testing::LabelDice;
using testing::OrganDice;

class StudyCt : public ::testing::TestWithParam<const char*> {};

TEST_P(StudyCt, IsSegmentedWithoutASeed) {
  const std::string folder = (testing::CasesFolder() / GetParam()).string();
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder << " (KERF_CASES)";
  Progress silent;
  SegmentationReport report;
  const LabelMap found = SegmentStudyCt(ReadVolume(folder + "/ct.nii.gz"), silent, &report);
  const LabelMap truth = ReadLabelMap(folder + "/labels.nii.gz");
  const double organ = OrganDice(*found.voxels, *truth.voxels),
               tumour = LabelDice(*found.voxels, *truth.voxels, 2),
               internal = LabelDice(*found.voxels, *truth.voxels, 3);
  printf("%s: organ %.3f tumour %.3f internal %.3f, %.1f %% open\n", GetParam(), organ, tumour,
         internal, 100 * report.open_surface);
  EXPECT_LT(report.open_surface, 0.1);
  EXPECT_GE(organ, 0.97);
  EXPECT_GE(tumour, 0.85);
  EXPECT_GE(internal, 0.85);
}

INSTANTIATE_TEST_SUITE_P(SegmentationData, StudyCt,
                         ::testing::Values("kidney-1", "kidney-2", "kidney-nocut", "liver-1"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

struct Organ {
  const char* name;
  OrganPreset preset;
  int label;
  Vec3 seed;            ///< LPS, the voxel at least 6 mm inside that is nearest to the centroid
  double least;         ///< Dice from that seed
  double least_spread;  ///< median Dice over seeds; one that is refused counts as 0
};
void PrintTo(const Organ& organ, std::ostream* out) { *out << organ.name; }

class RealCt : public ::testing::TestWithParam<Organ> {
 protected:
  void SetUp() override {
    const std::string folder = testing::DataFolder() + "/ct-abdomen";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder << " (KERF_DATA)";
    ct_ = ReadVolume(folder + "/ct.nii.gz");
    reference_ = ReadLabelMap(folder + "/reference_labels.nii.gz");
  }
  double DiceFrom(const std::vector<Vec3>& seeds, SegmentationReport* report = nullptr) const {
    SegmentationRequest request;
    request.preset = GetParam().preset;
    for (const Vec3& seed : seeds) request.seeds.push_back({SeedKind::Organ, seed, "seed"});
    Progress silent;
    const LabelMap found = SegmentCt(ct_, request, silent, report);
    return Dice(
        *found.voxels, *reference_.voxels, [](int v) { return v > 0; },
        [&](int v) { return v == GetParam().label; });
  }
  /// Voxels of the organ at least two voxels (6 mm) from everything else.
  std::vector<Vec3> Inside() const {
    const auto& grid = reference_.grid;
    std::vector<Vec3> points;
    for (int k = 2; k + 2 < grid.size[2]; ++k)
      for (int j = 2; j + 2 < grid.size[1]; ++j)
        for (int i = 2; i + 2 < grid.size[0]; ++i) {
          bool all = true;
          for (int a = -2; a <= 2 && all; ++a)
            for (int b = -2; b <= 2 && all; ++b)
              for (int c = -2; c <= 2 && all; ++c)
                all = a * a + b * b + c * c > 4 ||
                      (*reference_.voxels)[grid.Offset(i + a, j + b, k + c)] == GetParam().label;
          if (all) points.push_back(grid.WorldFromIndex(Vec3(i, j, k)));
        }
    return points;
  }
  Volume ct_;
  LabelMap reference_;
};

TEST_P(RealCt, IsSegmentedFromOneSeed) {
  const auto start = std::chrono::steady_clock::now();
  const double dice = DiceFrom({GetParam().seed});
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  printf("%s: %.3f in %.1f s\n", GetParam().name, dice, seconds);
  EXPECT_GE(dice, GetParam().least);
}

TEST_P(RealCt, IsSegmentedFromMostSeedsWellInside) {
  const char* wanted = std::getenv("KERF_SEEDS");
  const int count = wanted ? std::atoi(wanted) : 1;
  const std::vector<Vec3> inside = Inside();
  ASSERT_GT(inside.size(), 50u);
  std::mt19937 random(7);
  std::vector<double> all;
  for (int n = 0; n < count; ++n) {
    const Vec3 seed = inside[random() % inside.size()];
    double dice = 0;
    SegmentationReport report;
    try {
      dice = DiceFrom({seed}, &report);
    } catch (const InputError& error) {
      printf("%s\n", error.what());
    }
    printf("%s from (%.0f, %.0f, %.0f): %.3f, %.0f ml, %.1f %% open, warnings:", GetParam().name,
           seed[0], seed[1], seed[2], dice, report.organ_ml, 100 * report.open_surface);
    for (const std::string& warning : report.warnings) printf(" %s;", warning.c_str());
    printf("\n");
    all.push_back(dice);
  }
  std::sort(all.begin(), all.end());
  printf("%s from %d seeds: worst %.3f, median %.3f, best %.3f\n", GetParam().name, count,
         all.front(), all[all.size() / 2], all.back());
  EXPECT_GE(all[all.size() / 2], GetParam().least_spread);
}

INSTANTIATE_TEST_SUITE_P(SegmentationData, RealCt,
                         ::testing::Values(Organ{"liver", OrganPreset::Liver, 5,
                                                 Vec3(-74, -185, 391), 0.9, 0.88},
                                           Organ{"right kidney", OrganPreset::Kidney, 2,
                                                 Vec3(-80, -128, 346), 0.88, 0.85},
                                           Organ{"left kidney", OrganPreset::Kidney, 3,
                                                 Vec3(88, -119, 361), 0.88, 0.85}),
                         [](const auto& info) {
                           std::string name = info.param.name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

class Liver : public RealCt {};

TEST_P(Liver, IsFoundWithoutASeed) {
  const double dice = DiceFrom({});
  printf("liver without a seed: %.3f\n", dice);
  EXPECT_GE(dice, 0.9);
}

INSTANTIATE_TEST_SUITE_P(SegmentationData, Liver,
                         ::testing::Values(Organ{"liver", OrganPreset::Liver, 5, Vec3::Zero(), 0.9,
                                                 0.88}),
                         [](const auto&) { return "abdomen"; });

/// There is no reference: the organ must reach from the front to the back of the abdomen, where
/// the arms beside the body darken it by 35 HU.
TEST(SegmentationData, FollowsALiverThatArmsDarken) {
  const std::string folder = testing::DataFolder() + "/ct-dicom";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder << " (KERF_DATA)";
  const Volume ct = ReadVolume(folder);
  SegmentationRequest request;
  Progress silent;
  SegmentationReport report;
  const LabelMap found = SegmentCt(ct, request, silent, &report);
  printf("ct-dicom: %.0f ml, tumour %.1f, internal %.1f ml\n", report.organ_ml, report.tumour_ml,
         report.internal_ml);
  const auto label = [&](int i, int j, int k) {
    return int((*found.voxels)[found.grid.Offset(i, j, k)]);
  };
  for (const int k : {4, 10, 15}) {
    EXPECT_EQ(label(160, 240, k), 1) << "in front, slice " << k;
    EXPECT_EQ(label(160, 355, k), 1) << "behind, slice " << k;
    EXPECT_EQ(label(400, 330, k), 0) << "spleen, slice " << k;
  }
}

}  // namespace
}  // namespace kerf
