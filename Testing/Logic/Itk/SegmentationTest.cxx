#include <gtest/gtest.h>

#include <chrono>
#include <random>

#include "Adapters/Itk/Segmentation.h"
#include "Adapters/Itk/VolumeFiles.h"
#include "Overlap.h"
#include "TestSupport.h"

namespace kerf {
namespace {

using testing::InputErrorOf;
using testing::LabelDice;
using testing::Listener;
using testing::OrganDice;
using testing::Says;

/// An ellipsoid of 50 × 30 × 26 mm half axes, 120 HU, in fat: a dark sphere at its rim, a bright
/// rod inside, a vessel that leaves it, noise of 15 HU. Grid oblique and anisotropic.
struct Phantom {
  Volume ct;
  std::vector<std::uint8_t> truth;
  Vec3 center = Vec3(5, -30, 200);
};

Phantom MakePhantom(bool left_handed = false) {
  Phantom p;
  auto& grid = p.ct.grid;
  grid.size = Eigen::Vector3i(96, 72, 52);
  grid.spacing_mm = Vec3(1.25, 1.25, 1.5);
  grid.direction = Eigen::AngleAxisd(0.25, Vec3(1, 1, 2).normalized()).toRotationMatrix();
  if (left_handed) grid.direction.col(2) *= -1;
  const Vec3 half = (grid.size.cast<double>() - Vec3::Ones()) / 2;
  grid.origin_mm = p.center - grid.direction * grid.spacing_mm.cwiseProduct(half);
  p.ct.source = "phantom";
  p.truth.assign(grid.VoxelCount(), 0);
  auto voxels = std::make_shared<std::vector<std::int16_t>>(grid.VoxelCount());
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 15);
  std::size_t at = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i, ++at) {
        const Vec3 local =
            grid.direction.transpose() * (grid.WorldFromIndex(Vec3(i, j, k)) - p.center);
        double hu = -90;
        if (local.cwiseQuotient(Vec3(50, 30, 26)).norm() < 1) {
          hu = 120;
          p.truth[at] = 1;
        }
        if ((local - Vec3(25, 18, 0)).norm() < 9 && p.truth[at]) {
          hu = 60;
          p.truth[at] = 2;
        }
        if (local.tail<2>().norm() < 3.5 && std::abs(local[0]) < 25) {
          hu = 600;
          p.truth[at] = 3;
        }
        // A vessel of the same brightness leaves the organ: not part of it.
        if (!p.truth[at] && (local - Vec3(0, local[1], 0)).norm() < 4 && local[1] > 0) hu = 120;
        (*voxels)[at] = std::int16_t(std::lround(hu + noise(random)));
      }
  p.ct.voxels = voxels;
  return p;
}

TEST(Segmentation, FindsOrganTumourAndRodFromOneSeedOnAnObliqueGrid) {
  for (const bool left_handed : {false, true}) {
    const Phantom p = MakePhantom(left_handed);
    SegmentationRequest request;
    request.preset = OrganPreset::Kidney;
    request.seeds = {{SeedKind::Organ, p.center + p.ct.grid.direction * Vec3(-30, 0, 0), "seed"}};
    Listener heard;
    SegmentationReport report;
    const LabelMap labels = SegmentCt(p.ct, request, heard, &report);
    EXPECT_TRUE(labels.grid.SameAs(p.ct.grid));
    EXPECT_GT(OrganDice(*labels.voxels, p.truth), 0.96);
    EXPECT_GT(LabelDice(*labels.voxels, p.truth, 2), 0.85);
    EXPECT_GT(LabelDice(*labels.voxels, p.truth, 3), 0.85);
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.holes, 0);
    EXPECT_TRUE(report.plausible);
    EXPECT_FALSE(report.touches_border);
    EXPECT_NEAR(report.organ_mean_hu, 120, 5);
    EXPECT_TRUE(heard.Heard("taken as tumour"));
  }
}

TEST(Segmentation, NeedsNoSeedWhereOneOrganFillsTheVolume) {
  const Phantom p = MakePhantom();
  Listener heard;
  const LabelMap first = SegmentStudyCt(p.ct, heard);
  EXPECT_GT(OrganDice(*first.voxels, p.truth), 0.96);
  EXPECT_TRUE(heard.Heard("no preset was given, taken as kidney"));
  Progress silent;
  EXPECT_EQ(*SegmentStudyCt(p.ct, silent).voxels, *first.voxels) << "not deterministic";
}

TEST(Segmentation, AssumesAPresetOnlyWhereOneOrganIsSeen) {
  Phantom p = MakePhantom();
  Listener heard;
  EXPECT_TRUE(HoldsOneOrgan(p.ct));
  EXPECT_EQ(AssumePreset(p.ct, heard), OrganPreset::Kidney);
  EXPECT_TRUE(heard.Heard("taken as kidney"));
  p.ct.grid.spacing_mm *= 2;
  EXPECT_FALSE(HoldsOneOrgan(p.ct));
}

TEST(Segmentation, TakesSeedsForTumourAndInnerStructure) {
  const Phantom p = MakePhantom();
  SegmentationRequest request;
  request.preset = OrganPreset::Kidney;
  request.seeds = {{SeedKind::Organ, p.center + p.ct.grid.direction * Vec3(-30, 0, 0), "organ"},
                   {SeedKind::Tumour, p.center + p.ct.grid.direction * Vec3(25, 17, 0), "tumour"},
                   {SeedKind::Internal, p.center, "internal"}};
  Listener heard;
  const LabelMap labels = SegmentCt(p.ct, request, heard);
  EXPECT_GT(LabelDice(*labels.voxels, p.truth, 2), 0.8);
  EXPECT_GT(LabelDice(*labels.voxels, p.truth, 3), 0.85);
  EXPECT_FALSE(heard.Heard("taken as tumour"));
}

/// A dark ball of 6 mm beside the organ, 4.5 mm off its surface, that a person calls the tumour.
TEST(Segmentation, SaysThatAPieceWasLeftOut) {
  Phantom p = MakePhantom();
  const Vec3 apart(-20, 38, 0);
  auto voxels = std::make_shared<std::vector<std::int16_t>>(*p.ct.voxels);
  for (std::size_t at = 0; at < voxels->size(); ++at) {
    const auto& s = p.ct.grid.size;
    const Vec3 index(double(at % s[0]), double(at / s[0] % s[1]), double(at / (s[0] * s[1])));
    const Vec3 local =
        p.ct.grid.direction.transpose() * (p.ct.grid.WorldFromIndex(index) - p.center);
    if ((local - apart).norm() < 6) (*voxels)[at] = 60;
  }
  p.ct.voxels = voxels;
  SegmentationRequest request;
  request.preset = OrganPreset::Kidney;
  request.seeds = {{SeedKind::Organ, p.center + p.ct.grid.direction * Vec3(-30, 0, 0), "organ"},
                   {SeedKind::Tumour, p.center + p.ct.grid.direction * apart, "tumour"}};
  Listener heard;
  SegmentationReport report;
  SegmentCt(p.ct, request, heard, &report);
  EXPECT_EQ(report.tumour_ml, 0);
  EXPECT_EQ(report.components, 1);
  EXPECT_NEAR(report.left_out_ml, 0.9, 0.3);
  EXPECT_TRUE(heard.Heard("phantom: the seed tumour lies outside the organ that was found"));
  EXPECT_TRUE(heard.Heard("ml that do not touch the organ were left out"));
  EXPECT_FALSE(heard.Heard("the seed organ"));
}

/// The same organ with half and with 1.75 times the lengths: 20 and 880 ml.
TEST(Segmentation, SaysThatAVolumeIsImplausible) {
  for (const double scale : {0.5, 1.0, 1.75}) {
    Phantom p = MakePhantom();
    p.ct.grid.spacing_mm *= scale;
    SegmentationRequest request;
    request.preset = OrganPreset::Kidney;
    request.seeds = {{SeedKind::Organ,
                      p.ct.grid.WorldFromIndex(p.ct.grid.size.cast<double>() / 2) -
                          scale * p.ct.grid.direction * Vec3(30, 0, 0),
                      "organ"}};
    Listener heard;
    SegmentationReport report;
    SegmentCt(p.ct, request, heard, &report);
    EXPECT_EQ(report.plausible, scale == 1) << scale << ": " << report.organ_ml << " ml";
    EXPECT_EQ(heard.Heard("phantom: the kidney that was found has"), scale != 1) << scale;
    EXPECT_EQ(heard.Heard("part of it may be missing"), scale < 1) << scale;
    EXPECT_EQ(heard.Heard("it may have leaked"), scale > 1) << scale;
  }
}

TEST(Segmentation, SaysThatTheOrganIsCutOff) {
  Phantom p = MakePhantom();
  const auto& grid = p.ct.grid;
  Volume cut = p.ct;  // without the slices of its upper third
  cut.grid.size[2] = 35;
  cut.voxels = std::make_shared<std::vector<std::int16_t>>(
      p.ct.voxels->begin(), p.ct.voxels->begin() + grid.Offset(0, 0, 35));
  SegmentationRequest request;
  request.preset = OrganPreset::Kidney;
  request.seeds = {{SeedKind::Organ, p.center + grid.direction * Vec3(-30, 0, 0), "organ"}};
  for (const bool is_cut : {false, true}) {
    Listener heard;
    SegmentationReport report;
    SegmentCt(is_cut ? cut : p.ct, request, heard, &report);
    EXPECT_EQ(report.touches_border, is_cut);
    EXPECT_EQ(heard.Heard("reaches the volume's border"), is_cut);
  }
}

TEST(Segmentation, RefusesSeedsThatCannotBeMeant) {
  const Phantom p = MakePhantom();
  Progress silent;
  SegmentationRequest request;
  request.preset = OrganPreset::Kidney;
  request.seeds_source = "seeds.mrk.json";
  const auto error = [&](SeedKind kind, const Vec3& local) {
    request.seeds = {{SeedKind::Organ, p.center + p.ct.grid.direction * Vec3(-30, 0, 0), "first"}};
    const Seed seed{kind, p.center + p.ct.grid.direction * local, "the seed"};
    if (kind == SeedKind::Organ)
      request.seeds = {seed};
    else
      request.seeds.push_back(seed);
    return InputErrorOf([&] { SegmentCt(p.ct, request, silent); });
  };
  EXPECT_TRUE(Says(error(SeedKind::Organ, Vec3(500, 0, 0)), "outside the volume"));
  EXPECT_TRUE(Says(error(SeedKind::Organ, Vec3(500, 0, 0)), "seeds.mrk.json: the seed"));
  EXPECT_TRUE(Says(error(SeedKind::Organ, Vec3(-50, 35, 20)), "HU"));
  EXPECT_TRUE(Says(error(SeedKind::Tumour, Vec3(-35, 0, 0)), "cannot be told"));
}

TEST(Segmentation, FindsNothingInFat) {
  Phantom p = MakePhantom();
  auto fat = std::make_shared<std::vector<std::int16_t>>(*p.ct.voxels);
  for (auto& v : *fat) v = std::min<std::int16_t>(v, -60);
  p.ct.voxels = fat;
  Progress silent;
  EXPECT_TRUE(Says(InputErrorOf([&] { SegmentStudyCt(p.ct, silent); }), "no organ"));
}

/// Cancels at the n-th question.
class Impatient : public Progress {
 public:
  explicit Impatient(int patience) : patience_(patience) {}
  bool IsCancelled() const override { return asked_++ >= patience_; }

 private:
  int patience_;
  mutable int asked_ = 0;
};

TEST(Segmentation, StopsSoonWhenCancelled) {
  const Phantom p = MakePhantom();
  for (const int patience : {0, 3, 10, 30}) {
    Impatient progress(patience);
    const auto start = std::chrono::steady_clock::now();
    EXPECT_THROW(SegmentStudyCt(p.ct, progress), Cancelled) << patience;
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
  }
}

}  // namespace
}  // namespace kerf
