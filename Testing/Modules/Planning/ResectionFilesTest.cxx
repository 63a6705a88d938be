// The planned resection goes through the case folder to the operating room.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "CaseIO/Markups.h"
#include "Session/ResectionFiles.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

struct EmptyCase {
  EmptyCase()
      : folder(
            (fs::temp_directory_path() / ("kerf-resection-" + std::to_string(getpid()))).string()) {
    fs::remove_all(folder);
    CaseWriter writer(folder);
    writer.Manifest().pseudonym = "case-1";
    writer.Commit();
  }
  ~EmptyCase() { fs::remove_all(folder); }
  std::string folder;
};

}  // namespace

TEST(ResectionFiles, ThePlanComesBackAndAnotherTakesItsPlace) {
  const EmptyCase empty;
  EXPECT_EQ(ReadResectionPlan(CaseFolder::Open(empty.folder)).line.rows(), 0);
  ResectionPlan plan;
  plan.line.resize(3, 3);
  plan.line << 1, 2, 3, 4.5, 5, 6, 7, 8.25, 9;
  plan.direction = Vec3(0.6, 0, 0.8);
  plan.depth_mm = 33;
  plan.margin_mm = 7;
  for (int round = 0; round < 2; ++round) {
    CaseWriter writer = CaseWriter::Update(empty.folder);
    StageResectionPlan(plan, &writer);
    MarkupList other{"Line", {{"a", {0, 0, 0}}, {"b", {5, 0, 0}}}};
    WriteMarkups(writer.Stage("plan/slicer.mrk.json", "plan"), {other});
    writer.Commit();
    const CaseFolder read = CaseFolder::Open(empty.folder);
    const ResectionPlan back = ReadResectionPlan(read);
    ASSERT_EQ(back.line.rows(), plan.line.rows());
    EXPECT_LT((back.line - plan.line).norm(), 1e-9);
    EXPECT_LT((back.direction - plan.direction).norm(), 1e-6);
    EXPECT_DOUBLE_EQ(back.depth_mm, plan.depth_mm);
    EXPECT_DOUBLE_EQ(back.margin_mm, plan.margin_mm);
    EXPECT_FALSE(back.follows_surface);
    ASSERT_EQ(ReadOtherPlannedLines(read).size(), 1u);  // what Slicer drew, and nothing twice
    plan.line.conservativeResize(2, 3);
    plan.depth_mm = 21;
  }
}

}  // namespace kerf
