#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "CaseIO/CaseFolder.h"
#include "CaseIO/InputHash.h"
#include "CaseIO/ResultsFiles.h"
#include "Core/Errors.h"
#include "TemporaryFolder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::MessageOf;
using testing::TemporaryFolder;

void Put(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

void WriteCase(const std::string& root, const std::string& mesh) {
  CaseWriter writer(root);
  writer.Manifest().pseudonym = PseudonymFromHash(Sha256OfText("ct"));
  writer.Manifest().provenance["program"] = "kerf";
  Put(writer.Stage("organ.vtu", "organ_mesh"), mesh);
  Put(writer.Stage("plan/margin.mrk.json", "plan"), "{}");
  writer.Commit();
}

std::string OpenMessage(const std::string& root) {
  return MessageOf<InputError>([&] { CaseFolder::Open(root); });
}

TEST(CaseFolder, WhatIsWrittenComesBack) {
  TemporaryFolder folder;
  WriteCase(folder / "case/", "mesh");
  const CaseFolder back = CaseFolder::Open(folder / "case");
  EXPECT_EQ(back.Manifest().pseudonym.substr(0, 5), "case-");
  EXPECT_EQ(back.Manifest().provenance.at("program"), "kerf");
  ASSERT_EQ(back.Manifest().files.size(), 2u);
  EXPECT_EQ(back.Manifest().files[0].bytes, 4u);
  EXPECT_TRUE(fs::exists(back.Path("organ_mesh")));
  EXPECT_TRUE(back.Has("plan"));
  EXPECT_THAT(MessageOf<InputError>([&] { back.Path("tumour"); }), HasSubstr("tumour"));
  EXPECT_EQ(FolderFormat(folder / "case"), "kerf-case");
  EXPECT_EQ(folder.EntryCount(), 1u) << "a staging folder was left behind";
}

TEST(CaseFolder, OneHashNamesAnInput) {
  TemporaryFolder folder;
  Progress silent;
  Put(folder / "ct.nrrd", "ct");
  EXPECT_EQ(Sha256OfInput(folder / "ct.nrrd", silent), Sha256OfText("ct"));
  fs::create_directories(folder / "series/more");
  Put(folder / "series/b", "two");
  Put(folder / "series/a", "one");
  Put(folder / "series/more/a", "three");
  EXPECT_EQ(Sha256OfInput(folder / "series", silent),
            Sha256OfText(Sha256OfText("one") + Sha256OfText("two") + Sha256OfText("three")));
  // What is planned again from a case's own CT is the same patient.
  CaseWriter writer(folder / "case");
  writer.Manifest().pseudonym = "case-1";
  writer.Manifest().provenance["input_sha256"] = Sha256OfText("the first input");
  Put(writer.Stage("ct.nrrd", "ct"), "ct");
  writer.Commit();
  EXPECT_EQ(Sha256OfInput(folder / "case/ct.nrrd", silent), Sha256OfText("the first input"));
}

TEST(CaseFolder, DamageIsNamed) {
  TemporaryFolder folder;
  WriteCase(folder / "case", "mesh");
  Put(folder / "case/organ.vtu", "mess");
  EXPECT_THAT(OpenMessage(folder / "case"), AllOf(HasSubstr("organ.vtu"), HasSubstr("SHA-256")));
  EXPECT_NO_THROW(CaseFolder::Open(folder / "case", false));
  fs::remove(folder / "case/organ.vtu");
  EXPECT_THAT(OpenMessage(folder / "case"), AllOf(HasSubstr("organ.vtu"), HasSubstr("missing")));
  EXPECT_THAT(OpenMessage(folder / "nothing"), HasSubstr("no folder"));
  EXPECT_THAT(OpenMessage(folder.Path()), HasSubstr("no case folder"));
}

TEST(CaseFolder, OlderSchemaIsReadNewerRefused) {
  TemporaryFolder folder;
  folder.Write("old/organ.vtu", "mesh");
  folder.Write("old/case.json", R"({"format": "kerf-case", "schema": 1, "files": ["organ.vtu"]})");
  const CaseFolder old = CaseFolder::Open(folder / "old");
  EXPECT_EQ(old.Manifest().schema, 1);
  EXPECT_TRUE(old.Has("organ_mesh")) << "the role follows from the name";

  WriteCase(folder / "case", "mesh");
  auto json = nlohmann::json::parse(folder.Read("case/case.json"));
  json["schema"] = CaseManifest::kSchema + 1;
  folder.Write("case/case.json", json.dump());
  EXPECT_THAT(OpenMessage(folder / "case"), AllOf(HasSubstr("schema"), HasSubstr("update Kerf")));
}

TEST(CaseFolder, ManifestsThatLieAreRefused) {
  TemporaryFolder folder;
  const std::pair<const char*, const char*> broken[] = {
      {R"({"format": "kerf-study"})", "study"},
      {R"({"schema": 2, "files": []})", "no case folder"},
      {R"({"format": "kerf-case", "files": []})", "schema"},
      {R"({"format": "kerf-case", "schema": 0, "files": []})", "schema"},
      {R"({"format": "kerf-case", "schema": 2})", "files"},
      {R"({"format": "kerf-case", "schema": 2, "files": [], "units": {"length": "m"}})", "units"},
      {R"({"format": "kerf-case", "schema": 2, "files": [], "space": "RAS"})", "space"},
      {R"({"format": "kerf-case", "schema": 2, "files": [{"path": "../x", "sha256": "0"}]})",
       "inside"},
      {R"({"format": "kerf-case", "schema": 2, "files": [{"path": "/etc/passwd", "sha256": "0"}]})",
       "inside"},
      {R"({"format": "kerf-case", "schema": 2, "files": [{"path": "x"}]})", "sha256"},
      {R"({"format": "kerf-)", "JSON"}};
  for (const auto& [text, element] : broken) {
    folder.Write("c/case.json", text);
    EXPECT_THAT(OpenMessage(folder / "c"), AllOf(HasSubstr("case.json"), HasSubstr(element)))
        << text;
  }
}

TEST(CaseFolder, ReplacingKeepsSessionsAndRefusesOtherFolders) {
  TemporaryFolder folder;
  WriteCase(folder / "case", "first");
  folder.Write("case/sessions/2024/journal.jsonl", "{}\n");
  WriteCase(folder / "case", "second");
  EXPECT_EQ(folder.Read("case/organ.vtu"), "second");
  EXPECT_EQ(folder.Read("case/sessions/2024/journal.jsonl"), "{}\n");
  EXPECT_EQ(folder.EntryCount(), 1u);

  folder.Write("thesis/chapter1.tex", "precious");
  EXPECT_THAT(MessageOf<UsageError>([&] { CaseWriter(folder / "thesis"); }), HasSubstr("thesis"));
  EXPECT_EQ(folder.Read("thesis/chapter1.tex"), "precious");
}

TEST(CaseFolder, UpdateChangesOnlyWhatIsStaged) {
  TemporaryFolder folder;
  WriteCase(folder / "case", "mesh");
  {
    CaseWriter writer = CaseWriter::Update(folder / "case");
    Put(writer.Stage("organ.vtu", "organ_mesh"), "changed");
    EXPECT_EQ(folder.Read("case/organ.vtu"), "mesh") << "the old case was written to";
  }
  EXPECT_EQ(folder.Read("case/organ.vtu"), "mesh");
  EXPECT_NO_THROW(CaseFolder::Open(folder / "case"));
  CaseWriter writer = CaseWriter::Update(folder / "case");
  Put(writer.Stage("landmarks.mrk.json", "landmarks"), "{}");
  writer.Remove("plan/margin.mrk.json");
  writer.Commit();
  const CaseFolder back = CaseFolder::Open(folder / "case");
  EXPECT_TRUE(back.Has("landmarks"));
  EXPECT_FALSE(back.Has("plan"));
  EXPECT_EQ(back.Manifest().provenance.at("program"), "kerf");
}

TEST(CaseFolder, AMissingStagedFileKeepsTheOldCase) {
  TemporaryFolder folder;
  WriteCase(folder / "case", "first");
  {
    CaseWriter writer(folder / "case");
    writer.Stage("organ.vtu", "organ_mesh");
    EXPECT_THAT(MessageOf<InputError>([&] { writer.Commit(); }), HasSubstr("never written"));
  }
  EXPECT_EQ(folder.Read("case/organ.vtu"), "first");
}

/// A process that dies while it writes (at every stage before the swap) leaves the old case whole.
TEST(CaseFolder, ACrashLeavesTheOldCaseWhole) {
  TemporaryFolder folder;
  WriteCase(folder / "case", "first");
  const pid_t child = fork();
  if (child == 0) {
    CaseWriter writer(folder / "case");
    Put(writer.Stage("organ.vtu", "organ_mesh"), "half a me");
    _exit(9);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_EQ(WEXITSTATUS(status), 9);
  EXPECT_EQ(OpenMessage(folder / "case"), "");
  EXPECT_EQ(folder.Read("case/organ.vtu"), "first");
}

}  // namespace
}  // namespace kerf
