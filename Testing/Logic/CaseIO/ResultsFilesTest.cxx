#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "CaseIO/AtomicFile.h"
#include "CaseIO/ResultsFiles.h"
#include "Core/Errors.h"
#include "Support/FileSizeLimit.h"
#include "TemporaryFolder.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using testing::MessageOf;
using testing::TemporaryFolder;

TEST(ResultsFiles, FeaturesHaveTheContractedColumns) {
  TemporaryFolder folder;
  FeaturesFile file(folder / "features.csv");
  FeatureSet features;
  features.id = {4, 9};
  features.status = {FeatureStatus::Tracked, FeatureStatus::Occluded};
  Points current(2, 3), rest(2, 3);
  current << 1, 2, 3, 4, 5, 6;
  rest << 0, 0, 0, -1.23456, 0, 0;
  file.Add(20, features, current, rest);
  file.Finish();
  EXPECT_EQ(folder.Read("features.csv"),
            "frame,id,x_mm,y_mm,z_mm,x0_mm,y0_mm,z0_mm,state\n"
            "20,4,1.0000,2.0000,3.0000,0.0000,0.0000,0.0000,tracked\n"
            "20,9,4.0000,5.0000,6.0000,-1.2346,0.0000,0.0000,occluded\n");
  EXPECT_EQ(FrameFileName(7, "organ", "vtp"), "frame_00007_organ.vtp");
}

TEST(ResultsFiles, CutsComeBackInLpsFromBothSpaces) {
  TemporaryFolder folder;
  CutRecord cut;
  cut.detected_frame = 81;
  cut.depth_mm = 12.5;
  cut.confidence = 0.9;
  cut.polyline_rest.resize(2, 3);
  cut.polyline_rest << 1, 2, 3, 4, 5, 6;
  WriteCutsFile(folder / "cuts.json", {cut});
  const auto json = nlohmann::json::parse(folder.Read("cuts.json"));
  EXPECT_EQ(json["space"], "LPS");
  EXPECT_EQ(json["cuts"][0]["detected_frame"], 81);
  const auto back = ReadCutsFile(folder / "cuts.json");
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(back[0].polyline_rest, cut.polyline_rest);
  EXPECT_EQ(back[0].depth_mm, 12.5);

  const auto ras =
      folder.Write("ras.json", R"({"space": "RAS", "cuts": [{"polyline_rest": [[-1, -2, 3]]}]})");
  EXPECT_EQ(Vec3(ReadCutsFile(ras)[0].polyline_rest.row(0).transpose()), Vec3(1, 2, 3));
  WriteCutsFile(folder / "none.json", {});
  EXPECT_TRUE(ReadCutsFile(folder / "none.json").empty());
}

TEST(ResultsFiles, BrokenCutsAreNamed) {
  TemporaryFolder folder;
  auto message = [&](const char* text) {
    return MessageOf<InputError>([&] { ReadCutsFile(folder.Write("c.json", text)); });
  };
  EXPECT_THAT(message("{}"), HasSubstr("cuts"));
  EXPECT_THAT(message(R"({"space": "MNI", "cuts": []})"), HasSubstr("MNI"));
  EXPECT_THAT(message(R"({"cuts": [{"polyline_rest": [[1, 2]]}]})"),
              HasSubstr("cuts[0].polyline_rest[0]"));
  EXPECT_THAT(message(R"({"cuts": [{"detected_frame": "x"}]})"), HasSubstr("detected_frame"));
}

TEST(ResultsFiles, TimingAndReliabilityComeBack) {
  TemporaryFolder folder;
  TimingRow t;
  t.frame = 3;
  t.tracking_ms = 4.25;
  t.total_ms = 9.5;
  WriteTimingFile(folder / "timing.csv", {t});
  EXPECT_THAT(folder.Read("timing.csv"),
              HasSubstr("frame,capture_ms,tracking_ms,targets_ms,detection_ms,cutting_ms,solve_ms,"
                        "structures_ms,render_ms,total_ms\n3,"));
  EXPECT_EQ(ReadTimingFile(folder / "timing.csv")[0].total_ms, 9.5);

  ReliabilityRow r{
      5, 0.2, "amber", 0.5, "few features, smoke", std::numeric_limits<double>::quiet_NaN()};
  WriteReliabilityFile(folder / "reliability.csv", {r});
  EXPECT_EQ(folder.Read("reliability.csv"),
            "frame,time_s,state,score,reason,tumour_u95_mm\n"
            "5,0.2000,amber,0.5000,\"few features, smoke\",\n");
  const auto back = ReadReliabilityFile(folder / "reliability.csv");
  EXPECT_EQ(back[0].reason, "few features, smoke");
  EXPECT_TRUE(std::isnan(back[0].tumour_u95_mm));
}

TEST(Journal, EveryLineIsOnDiskAtOnceAndIsAnObject) {
  TemporaryFolder folder;
  Journal journal(folder / "s/journal.jsonl");
  journal.Write(0.04, 1, "gate", {{"state", "green"}, {"score", 0.5}, {"cut", false}});
  journal.Write(0.08, 2, "inputs", {{"names", std::vector<std::string>{"a", "b"}}, {"n", 2}});
  std::istringstream lines(folder.Read("s/journal.jsonl"));
  std::string line;
  std::vector<nlohmann::json> entries;
  while (std::getline(lines, line)) entries.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(entries[0]["event"], "gate");
  EXPECT_EQ(entries[0]["frame"], 1);
  EXPECT_EQ(entries[0]["time_s"], 0.04);
  EXPECT_EQ(entries[0]["data"]["state"], "green");
  EXPECT_EQ(entries[0]["data"]["cut"], false);
  EXPECT_EQ(entries[1]["data"]["names"].size(), 2u);
  {
    Journal again(folder / "s/journal.jsonl", true);
    again.Write(1, 25, "end");
  }
  const std::string text = folder.Read("s/journal.jsonl");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
}

TEST(Journal, AFullDiskIsNamedAsTheSystemNamesIt) {
  Journal journal("/dev/full", true);
  const std::string message = MessageOf<InputError>([&] { journal.Write(0, 0, "start"); });
  EXPECT_THAT(message, HasSubstr("/dev/full"));
  EXPECT_THAT(message, HasSubstr("cannot be written any more: No space left on device"));
}

/// What committing the file says after `write` while none grows beyond 1,000 bytes.
template <class Write>
std::string MessageWithLittleRoom(AtomicFile& file, Write write) {
  const testing::FileSizeLimit limit(1000);
  write();
  return MessageOf<InputError>([&] { file.Commit(); });
}

TEST(AtomicFile, AWriteThatFailsIsNamedAsTheSystemNamesIt) {
  TemporaryFolder folder;
  const std::string path = folder.Write("kept.csv", "old");
  for (const std::size_t bytes : {2000, 200000}) {  // less and more than a stream's buffer
    AtomicFile file(path);
    const std::string message =
        MessageWithLittleRoom(file, [&] { file.Stream() << "first," << std::string(bytes, 'x'); });
    EXPECT_THAT(message, HasSubstr("kept.csv: could not be written completely: File too large"));
    EXPECT_EQ(folder.Read("kept.csv"), "old");
  }
  EXPECT_EQ(folder.EntryCount(), 1u);
}

/// As a report of many rows: what fails is a write long before the last, and other calls come
/// between.
TEST(AtomicFile, TheReasonOfAnEarlyWriteIsNotForgotten) {
  TemporaryFolder folder;
  const std::string path = folder.Write("kept.csv", "old");
  for (const std::size_t bytes : {100, 20000}) {  // through the stream's buffer, and past it
    AtomicFile file(path);
    const std::string message = MessageWithLittleRoom(file, [&] {
      for (int row = 0; row < 500; ++row) file.Stream() << std::string(bytes, 'x') << '\n';
      EXPECT_FALSE(file.Stream());
      EXPECT_FALSE(std::ifstream(folder / "none"));  // errno is of something else now
    });
    EXPECT_THAT(message, HasSubstr("kept.csv: could not be written completely: File too large"));
    EXPECT_EQ(folder.Read("kept.csv"), "old");
  }
  EXPECT_EQ(folder.EntryCount(), 1u);
}

TEST(Sha256, KnownValues) {
  TemporaryFolder folder;
  EXPECT_EQ(Sha256OfText("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256OfFile(folder.Write("e", "")),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_THAT(MessageOf<InputError>([&] { Sha256OfFile(folder / "none"); }), HasSubstr("none"));
}

}  // namespace
}  // namespace kerf
