#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "CaseIO/Csv.h"
#include "Core/Errors.h"
#include "TemporaryFolder.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using testing::MessageOf;
using testing::TemporaryFolder;

TEST(Csv, ReadsColumnsByNameWhateverTheOrder) {
  TemporaryFolder folder;
  const auto file = folder.Write("a.csv",
                                 "\xEF\xBB\xBF"
                                 "b, a\r\n1.5,2\r\n\r\n\"-3e2\",4\r\n");
  const CsvTable table = CsvTable::Read(file);
  ASSERT_EQ(table.Rows(), 2u);
  EXPECT_EQ(table.Integer(0, table.Column("a")), 2);
  EXPECT_DOUBLE_EQ(table.Number(1, table.Column("b")), -300.0);
  EXPECT_FALSE(table.HasColumn("c"));
}

TEST(Csv, NamesFileLineAndColumn) {
  TemporaryFolder folder;
  const auto file = folder.Write("a.csv", "id,x_mm\n1,2\n3,nan\n4,5x\n2.5,1\n");
  const CsvTable table = CsvTable::Read(file);
  auto number = [&](std::size_t row) {
    return MessageOf<InputError>([&] { table.Number(row, 1); });
  };
  EXPECT_EQ(number(0), "");
  EXPECT_THAT(number(1), HasSubstr(file + ": line 3, column x_mm"));
  EXPECT_THAT(number(2), HasSubstr("\"5x\" is not a finite number"));
  EXPECT_THAT(MessageOf<InputError>([&] { table.Integer(3, 0); }), HasSubstr("whole number"));
  EXPECT_THAT(MessageOf<InputError>([&] { table.Column("y_mm"); }), HasSubstr("y_mm"));
}

TEST(Csv, RefusesWhatIsNoTable) {
  TemporaryFolder folder;
  EXPECT_THAT(MessageOf<InputError>([&] { CsvTable::Read(folder / "none.csv"); }),
              HasSubstr("cannot be opened"));
  EXPECT_THAT(MessageOf<InputError>([&] { CsvTable::Read(folder.Write("e.csv", "\n")); }),
              HasSubstr("empty"));
  EXPECT_THAT(MessageOf<InputError>([&] { CsvTable::Read(folder.Write("r.csv", "a,b\n1\n")); }),
              HasSubstr("line 2"));
  EXPECT_THAT(MessageOf<InputError>([&] { CsvTable::Read(folder.Write("d.csv", "a,a\n")); }),
              HasSubstr("twice"));
}

TEST(Csv, WritesWhatItReads) {
  TemporaryFolder folder;
  CsvWriter writer(folder / "sub/w.csv", {"frame", "reason", "x_mm"});
  writer << 7 << "fast, \"blurred\"";
  writer.Fixed(-0.00001, 4);
  writer << 8 << "";
  writer.Fixed(std::numeric_limits<double>::quiet_NaN(), 4);
  EXPECT_FALSE(std::filesystem::exists(folder / "sub/w.csv")) << "appears before it is complete";
  writer.Finish();
  EXPECT_EQ(folder.Read("sub/w.csv"),
            "frame,reason,x_mm\n7,\"fast, \"\"blurred\"\"\",0.0000\n8,,\n");
  const CsvTable table = CsvTable::Read(folder / "sub/w.csv");
  EXPECT_EQ(table.Text(0, 1), "fast, \"blurred\"");
}

TEST(Csv, AnAbandonedFileLeavesTheOldOneAlone) {
  TemporaryFolder folder;
  folder.Write("w.csv", "old\n");
  { CsvWriter writer(folder / "w.csv", {"new"}); }
  EXPECT_EQ(folder.Read("w.csv"), "old\n");
  EXPECT_EQ(folder.EntryCount(), 1u) << "a temporary file was left behind";
}

TEST(Csv, SaysWhenAFileCannotBeWritten) {
  TemporaryFolder folder;
  folder.Write("file", "");
  EXPECT_THAT(MessageOf<InputError>([&] { CsvWriter(folder / "file/w.csv", {"a"}); }),
              HasSubstr("cannot be"));
}

}  // namespace
}  // namespace kerf
