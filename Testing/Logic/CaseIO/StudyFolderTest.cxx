#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "CaseIO/StudyFolder.h"
#include "Core/Errors.h"
#include "Support/CasesFolder.h"
#include "TemporaryFolder.h"

namespace kerf {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MessageOf;
using testing::TemporaryFolder;

void WriteMinimalStudy(const TemporaryFolder& folder) {
  folder.Write("camera.yml", "");
  folder.Write("organ_surface.stl", "");
}

std::string OpenMessage(const TemporaryFolder& folder) {
  return MessageOf<InputError>([&] { OpenStudy(folder.Path()); });
}

TEST(StudyFolder, ReadsWhatCaseJsonSays) {
  TemporaryFolder folder;
  WriteMinimalStudy(folder);
  folder.Write("film.mp4", "");
  folder.Write("case.json", R"({"name": "secret", "feature_count": 225, "eval_frames": [20, 5, 20],
      "video": {"file": "film.mp4", "fps": 30, "frames": 40, "width": 960, "height": 540},
      "extrusion_hint_ct": [0, 2, 0],
      "suggested_parameters": {"young_kPa": 15, "n": 8, "r_cut_mm": 7}})");
  const Study study = OpenStudy(folder.Path() + "/");
  EXPECT_EQ(study.name, std::filesystem::path(folder.Path()).filename());
  EXPECT_EQ(study.feature_count, 225);
  EXPECT_THAT(study.eval_frames, ElementsAre(5, 20));
  EXPECT_EQ(study.frames_per_second, 30.0);
  EXPECT_THAT(study.video, HasSubstr("film.mp4"));
  EXPECT_EQ(study.frames, 40);
  ASSERT_TRUE(study.extrusion_hint.has_value());
  EXPECT_EQ(*study.extrusion_hint, Vec3(0, -1, 0)) << "RAS has to become LPS";
  EXPECT_EQ(study.suggested.outliers, 8);
  EXPECT_EQ(study.suggested.cut_radius_mm, 7.0);
  EXPECT_FALSE(study.suggested.tau.has_value());
}

TEST(StudyFolder, DoesWithoutCaseJsonAndVideo) {
  TemporaryFolder folder;
  WriteMinimalStudy(folder);
  const Study study = OpenStudy(folder.Path());
  EXPECT_TRUE(study.video.empty());
  EXPECT_THAT(study.FramesToWrite(13), ElementsAre(0, 5, 10, 12));
  EXPECT_THAT(study.FramesToWrite(11), ElementsAre(0, 5, 10));
  EXPECT_TRUE(study.FramesToWrite(0).empty());
  folder.Write("case.json", R"({"video": {"file": "frames/f%05d.png"}})");
  EXPECT_THAT(OpenStudy(folder.Path()).video, HasSubstr("frames/f%05d.png"));
}

TEST(StudyFolder, RefusesWithFileAndKey) {
  TemporaryFolder folder;
  EXPECT_THAT(OpenMessage(folder), HasSubstr("camera.yml"));
  folder.Write("camera.yml", "");
  EXPECT_THAT(OpenMessage(folder), HasSubstr("labels.nii.gz"));
  WriteMinimalStudy(folder);
  EXPECT_EQ(OpenMessage(folder), "");
  const std::pair<const char*, const char*> broken[] = {
      {R"({"format": "kerf-case"})", "case folder"},
      {R"({"format": "other"})", "format"},
      {R"({"video": {"fps": 0}})", "video.fps"},
      {R"({"video": {"frames": 2.5}})", "video.frames"},
      {R"({"video": {"file": "../other.mp4"}})", "video.file"},
      {R"({"eval_frames": [1, "x"]})", "eval_frames[1]"},
      {R"({"eval_frames": [-1]})", "eval_frames[0]"},
      {R"({"feature_count": 0})", "feature_count"},
      {R"({"extrusion_hint_ct": [0, 0, 0]})", "extrusion_hint_ct"},
      {R"({"suggested_parameters": {"tau": "8"}})", "suggested_parameters.tau"},
      {R"({"video": )", "not valid JSON"},
      {"[]", "object"}};
  for (const auto& [text, element] : broken) {
    folder.Write("case.json", text);
    EXPECT_THAT(OpenMessage(folder), ::testing::AllOf(HasSubstr("case.json"), HasSubstr(element)))
        << text;
  }
  folder.Write("case.json", R"({"format": "kerf-study"})");
  EXPECT_EQ(OpenMessage(folder), "");
  EXPECT_THAT(MessageOf<InputError>([&] { OpenStudy(folder / "none"); }), HasSubstr("no folder"));
}

constexpr char kRest[] =
    "id,use,x_mm,y_mm,z_mm,u_px,v_px\n7,1,1,2,3,10,20\n3,0,4,5,6,11,21\n9,1,0,0,0,5,5\n";

TEST(StudyFolder, TracksJoinTheirRestPositions) {
  TemporaryFolder folder;
  const auto rest = folder.Write("features_rest.csv", kRest);
  const auto tracks = folder.Write(
      "t.csv", "frame,id,u_px,v_px,visible,x_mm\n0,7,1,2,1,9\n0,3,3,4,1,9\n2,7,5,6,0,9\n");
  const TrackTable table = ReadTracks(tracks, rest);
  EXPECT_THAT(table.id, ElementsAre(3, 7));
  EXPECT_EQ(table.frames, 3);
  EXPECT_EQ(Vec3(table.rest.row(1).transpose()), Vec3(-1, -2, 3));
  EXPECT_TRUE(table.visible[table.Row(0, 1)]);
  EXPECT_FALSE(table.visible[table.Row(1, 1)]) << "a frame without a row is not seen";
  EXPECT_EQ(Vec2(table.pixels.row(table.Row(1, 1)).transpose()), Vec2(1, 2))
      << "the last known position stands";
  EXPECT_EQ(Vec2(table.pixels.row(table.Row(2, 1)).transpose()), Vec2(5, 6));
}

TEST(StudyFolder, TracksNameWhatIsWrong) {
  TemporaryFolder folder;
  const auto rest = folder.Write("features_rest.csv", kRest);
  auto message = [&](const std::string& rows) {
    const auto file = folder.Write("t.csv", "frame,id,u_px,v_px,visible\n" + rows);
    return MessageOf<InputError>([&] { ReadTracks(file, rest); });
  };
  EXPECT_EQ(message("0,7,1,2,1\n"), "");
  EXPECT_THAT(message("0,7,1,2,1\n0,8,1,2,1\n"),
              ::testing::AllOf(HasSubstr("unknown id 8"), HasSubstr("line 3")));
  EXPECT_THAT(message("0,7,1,2,1\n0,7,1,2,1\n"), HasSubstr("twice"));
  EXPECT_THAT(message("-1,7,1,2,1\n"), HasSubstr("negative"));
  EXPECT_THAT(message("0,7,x,2,1\n"), HasSubstr("u_px"));
  EXPECT_THAT(message("2000000000,7,1,2,1\n"), HasSubstr("too large"));
  EXPECT_THAT(message(""), HasSubstr("no tracks"));
  const auto twice = folder.Write("features_rest.csv", std::string(kRest) + "7,1,1,2,3,10,20\n");
  EXPECT_THAT(MessageOf<InputError>([&] { ReadRestFeatures(twice); }), HasSubstr("id 7"));
}

TEST(StudyFolder, ReadsTheSimulatedStudies) {
  const std::filesystem::path cases = kerf::testing::CasesFolder();
  if (!std::filesystem::exists(cases / "kidney-1"))
    GTEST_SKIP() << "no studies at " << cases << " (set KERF_CASES)";
  for (const char* name : {"kidney-1", "silicone-left"}) {
    const Study study = OpenStudy((cases / name).string());
    const TrackTable tracks = ReadTracks(study.features_2d, study.features_rest);
    EXPECT_EQ(static_cast<int>(tracks.id.size()), study.feature_count);
    EXPECT_EQ(tracks.frames, study.frames);
    EXPECT_EQ(ReadLandmarks(study.landmarks).size(), 8u);
    EXPECT_EQ(study.labels.empty(), std::string(name) == "silicone-left");
    EXPECT_TRUE(study.extrusion_hint.has_value());
  }
}

}  // namespace
}  // namespace kerf
