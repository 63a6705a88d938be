/// The whole of `validate` over the phantom under two names: beside each other or one after the
/// other, the same figures, and a page to look at.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "Adapters/Rendering/VirtualDisplay.h"
#include "Logic/CaseIO/TemporaryFolder.h"
#include "Pipelines/ValidatePipeline.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;

TEST(ValidatePhantom, StudiesBesideEachOtherGiveTheSameBitsAndAPageWithPictures) {
  const fs::path phantom = KERF_TEST_PHANTOM;
  ASSERT_TRUE(fs::exists(phantom / "case.json")) << "the phantom is made by ctest";
  TemporaryFolder folder;
  for (const char* name : {"one", "two"})
    fs::create_directory_symlink(phantom, fs::path(folder / name));
  ValidateRequest request;
  request.studies = {folder / "one", folder / "two"};
  request.variants = {{Method::Kerf, true, true}, {Method::Kerf, true, false}};
  request.tetrahedra = 2000;
  Progress silent;
  std::vector<ValidationRun> runs[2];
  for (const int jobs : {1, 2}) {
    request.jobs = jobs;
    request.output = folder / ("jobs" + std::to_string(jobs));
    runs[jobs - 1] = Validate(request, silent);
    ASSERT_EQ(runs[jobs - 1].size(), 4u);
  }
  for (int i = 0; i < 4; ++i) {
    ASSERT_EQ(runs[0][i].error, "");
    EXPECT_EQ(runs[0][i].study, runs[1][i].study);
    EXPECT_EQ(runs[0][i].scores.final_values, runs[1][i].scores.final_values);
    for (const char* file : {"organ_final.vtu", "features.csv", "cuts.json"}) {
      const auto read = [&](const ValidationRun& run) {
        return folder.Read(fs::relative(fs::path(run.results) / file, folder.Path()).string());
      };
      EXPECT_TRUE(read(runs[0][i]) == read(runs[1][i])) << runs[0][i].results << ", " << file;
    }
  }
  const std::string page = folder.Read("jobs2/validation.html");
  EXPECT_THAT(page, HasSubstr("2 studies ran beside each other"));
  EXPECT_THAT(folder.Read("jobs1/validation.html"), Not(HasSubstr("beside each other")));
  ASSERT_TRUE(RenderingAvailable()) << "the packages of ./kerf bring Xvfb";
  const std::regex picture("data:image/jpeg");
  EXPECT_EQ(std::distance(std::sregex_iterator(page.begin(), page.end(), picture), {}), 4 * 3)
      << "of each run the overlay and the errors from two sides";
  EXPECT_FALSE(fs::exists(folder / "jobs2/one/kerf-tracks-cut/overlay.mp4"));
}

}  // namespace
}  // namespace kerf
