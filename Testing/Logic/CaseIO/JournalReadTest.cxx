#include <gtest/gtest.h>

#include <fstream>

#include "CaseIO/JournalRead.h"
#include "Core/Errors.h"
#include "TemporaryFolder.h"

namespace kerf {
namespace {

using testing::TemporaryFolder;

TEST(JournalRead, WhatWasWrittenComesBackBitByBit) {
  TemporaryFolder folder;
  const std::string path = folder / "journal.jsonl";
  const std::vector<double> line{0.1, -1.0 / 3.0, 1e-17, 12345.678901234567};
  {
    Journal journal(path);
    journal.Write(1.25, 7, "cut drawn", {{"line", line}, {"cut", 2}, {"depth_mm", 4.0}});
    journal.Write(2.0, 8, "mark",
                  {{"text", "überall"}, {"names", std::vector<std::string>{"a", "b"}}});
  }
  const auto entries = ReadJournal(path);
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(entries[0].event, "cut drawn");
  EXPECT_EQ(entries[0].frame, 7);
  EXPECT_DOUBLE_EQ(entries[0].time_s, 1.25);
  EXPECT_EQ(entries[0].Numbers("line"), line);
  EXPECT_EQ(entries[0].Number("cut"), 2.0);
  EXPECT_EQ(entries[0].Number("depth_mm"), 4.0);
  EXPECT_FALSE(entries[0].Number("none"));
  ASSERT_NE(entries[1].Text("text"), nullptr);
  EXPECT_EQ(*entries[1].Text("text"), "überall");
}

TEST(JournalRead, ALineThatACrashCutOffIsLeftOut) {
  TemporaryFolder folder;
  const std::string path = folder / "journal.jsonl";
  std::ofstream(path) << "{\"time_s\":0.0,\"frame\":0,\"event\":\"start\",\"data\":{}}\n"
                      << "{\"time_s\":0.1,\"frame\":1,\"eve";
  EXPECT_EQ(ReadJournal(path).size(), 1u);
}

TEST(JournalRead, GarbageNamesFileAndLine) {
  TemporaryFolder folder;
  const std::string path = folder / "journal.jsonl";
  std::ofstream(path) << "{\"event\":\"start\"}\nnonsense\n";
  try {
    ReadJournal(path);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.File(), path);
    EXPECT_EQ(error.Element(), "line 2");
  }
  EXPECT_THROW(ReadJournal(folder / "none.jsonl"), InputError);
}

}  // namespace
}  // namespace kerf
