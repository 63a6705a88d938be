#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "Adapters/Itk/Seeds.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

class SeedsTest : public ::testing::Test {
 protected:
  SeedsTest() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = (std::filesystem::temp_directory_path() /
             (std::string("kerf-seeds-") + info->name() + ".mrk.json"))
                .string();
  }
  ~SeedsTest() override { std::filesystem::remove(path_); }
  std::vector<Seed> Read(const std::string& text) {
    std::ofstream(path_) << text;
    return ReadSeeds(path_);
  }
  std::string ErrorOf(const std::string& text) {
    try {
      Read(text);
    } catch (const InputError& error) {
      EXPECT_EQ(error.File(), path_);
      return error.what();
    }
    return "no error";
  }
  std::string path_;
};

std::string Markups(const std::string& system, const std::string& points) {
  return R"({"markups":[{"type":"Fiducial","coordinateSystem":")" + system +
         R"(","controlPoints":[)" + points + "]}]}";
}

TEST_F(SeedsTest, ReadsKindsAndSpaces) {
  const std::string points =
      R"({"id":"1","label":"organ-1","position":[1,2,3],"positionStatus":"defined"},
         {"label":"Tumor","position":[4,5,6]},{"label":"internal","position":[7,8,9]},
         {"label":"background 2","position":[0,0,0]},
         {"label":"organ","position":[0,0,0],"positionStatus":"undefined"})";
  const auto lps = Read(Markups("LPS", points));
  ASSERT_EQ(lps.size(), 4u);
  EXPECT_EQ(lps[0].kind, SeedKind::Organ);
  EXPECT_EQ(lps[1].kind, SeedKind::Tumour);
  EXPECT_EQ(lps[2].kind, SeedKind::Internal);
  EXPECT_EQ(lps[3].kind, SeedKind::Background);
  EXPECT_EQ(lps[0].position_mm, Vec3(1, 2, 3));
  const auto ras = Read(Markups("RAS", points));
  EXPECT_EQ(ras[0].position_mm, Vec3(-1, -2, 3));
}

TEST_F(SeedsTest, NamesTheBrokenElement) {
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(ErrorOf("{"), "JSON"));
  EXPECT_TRUE(has(ErrorOf("[]"), "markups"));
  EXPECT_TRUE(has(ErrorOf(Markups("LPS", "")), "controlPoints"));
  EXPECT_TRUE(
      has(ErrorOf(Markups("XYZ", R"({"label":"organ","position":[1,2,3]})")), "coordinateSystem"));
  EXPECT_TRUE(has(ErrorOf(Markups("LPS", R"({"label":"spleen","position":[1,2,3]})")),
                  "controlPoints[0].label"));
  EXPECT_TRUE(has(ErrorOf(Markups("LPS", R"({"label":"organ","position":[1,2]})")),
                  "controlPoints[0].position"));
  EXPECT_TRUE(has(ErrorOf(Markups("LPS", R"({"label":"organ","position":[1,null,2]})")),
                  "controlPoints[0].position"));
}

TEST_F(SeedsTest, RefusesASeedOutsideTheVolume) {
  GridGeometry grid;
  grid.size = Eigen::Vector3i(10, 10, 10);
  grid.spacing_mm = Vec3(1, 1, 2);
  auto seeds = Read(Markups("LPS", R"({"label":"organ","position":[9.4,0,18.9]})"));
  EXPECT_NO_THROW(CheckSeedsInside(seeds, grid, path_));
  seeds[0].position_mm[0] = 9.6;
  EXPECT_THROW(CheckSeedsInside(seeds, grid, path_), InputError);
}

}  // namespace
}  // namespace kerf
