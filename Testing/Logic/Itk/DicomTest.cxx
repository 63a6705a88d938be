#include <gtest/gtest.h>

#include "Adapters/Itk/VolumeFiles.h"
#include "DicomFiles.h"
#include "TestSupport.h"

namespace kerf {
namespace {

using testing::DicomFile;
using testing::InputErrorOf;
using testing::Listener;
using testing::Says;

class DicomTest : public testing::FolderTest {
 protected:
  static DicomFile Slice(int n) { return DicomFile(8, 6, 100 + 2.0 * n, n); }
  std::string File(int n) const { return Path("slice" + std::to_string(n)); }
  /// Files in an order that is not the order of the slices.
  void WriteSeries(int count = 5) {
    for (int n = 0; n < count; ++n) Slice(n).Write(File((n * 3) % count));
  }
  Volume Read(const std::string& series = "") {
    return ReadVolume(folder_.string(), {series}, heard_);
  }
  std::string Error() {
    return InputErrorOf([&] { Read(); });
  }
  Listener heard_;
};

TEST_F(DicomTest, ReadsASeriesInTheOrderOfItsPositions) {
  WriteSeries();
  const Volume volume = Read();
  EXPECT_EQ(volume.grid.size, Eigen::Vector3i(8, 6, 5));
  EXPECT_TRUE(volume.grid.spacing_mm.isApprox(Vec3(0.75, 0.5, 2)));
  EXPECT_TRUE(volume.grid.origin_mm.isApprox(Vec3(10, -20, 100)));
  EXPECT_TRUE(volume.grid.direction.isApprox(Mat3::Identity()));
  for (int k = 0; k < 5; ++k)
    EXPECT_EQ((*volume.voxels)[volume.grid.Offset(3, 2, k)], -500 + 30 + 200 + k);
  EXPECT_EQ(volume.metadata.at("series"), "1.2.3.4");
  for (const auto& [key, value] : volume.metadata) EXPECT_EQ(value.find("Doe"), std::string::npos);
  EXPECT_TRUE(heard_.warnings.empty()) << heard_.warnings.front();
}

TEST_F(DicomTest, KeepsAnObliqueOrientation) {
  const double c = std::cos(0.3), s = std::sin(0.3);
  for (int n = 0; n < 4; ++n) {
    DicomFile file = Slice(n);
    file.Text(0x00200037, "DS", std::to_string(c) + "\\" + std::to_string(s) + "\\0\\0\\0\\-1");
    const Vec3 normal = Vec3(c, s, 0).cross(Vec3(0, 0, -1));
    const Vec3 at = Vec3(1, 2, 3) + 2.5 * n * normal;
    file.Position(at[0], at[1], at[2]);
    file.Write(File(n));
  }
  const Volume volume = Read();
  EXPECT_NEAR(volume.grid.spacing_mm[2], 2.5, 1e-4);
  EXPECT_TRUE(volume.grid.direction.col(0).isApprox(Vec3(c, s, 0), 1e-5));
  EXPECT_TRUE(volume.grid.direction.col(1).isApprox(Vec3(0, 0, -1), 1e-5));
  EXPECT_NEAR(volume.grid.direction.determinant(), 1, 1e-9);
  EXPECT_TRUE(heard_.Heard("slice thickness 2.00 mm"));
}

TEST_F(DicomTest, WarnsOfMissingUidsAndForeignFiles) {
  for (int n = 0; n < 4; ++n) {
    DicomFile file = Slice(n);
    for (const std::uint32_t tag : {0x00080016u, 0x00080018u, 0x0020000du, 0x0020000eu})
      file.Text(tag, "UI", "");
    file.Write(File(n));
  }
  WriteBytes(Path("notes.txt"), "no image");
  const Volume volume = Read();
  EXPECT_EQ(volume.grid.size[2], 4);
  EXPECT_EQ(volume.metadata.at("series"), "no-uid-1");
  EXPECT_TRUE(heard_.Heard("Instance UIDs are missing"));
  EXPECT_TRUE(heard_.Heard("notes.txt"));
}

TEST_F(DicomTest, RefusesTwoPatientsWithoutNamingThem) {
  WriteSeries();
  DicomFile other = Slice(2);
  other.Text(0x00100020, "LO", "P2");
  other.Text(0x00100010, "PN", "Roe^Richard");
  other.Write(File(2 * 3 % 5));
  const std::string message = Error();
  EXPECT_TRUE(Says(message, "two patients"));
  EXPECT_TRUE(Says(message, "PatientID"));
  EXPECT_EQ(message.find("Roe"), std::string::npos);
}

TEST_F(DicomTest, RefusesAMissingSlice) {
  WriteSeries();
  std::filesystem::remove(File(3 * 3 % 5));
  const std::string message = Error();
  EXPECT_TRUE(Says(message, "1 slice(s) missing"));
  EXPECT_TRUE(Says(message, "ImagePositionPatient"));
  EXPECT_TRUE(Says(message, File(4 * 3 % 5)));
}

TEST_F(DicomTest, RefusesATruncatedSlice) {
  WriteSeries();
  const std::string bytes = Slice(1).Bytes();
  for (const std::size_t cut : {bytes.size() - 40, bytes.size() - 2}) {
    WriteBytes(File(3), bytes.substr(0, cut));
    const std::string message = Error();
    EXPECT_TRUE(Says(message, "slice3"));
    EXPECT_TRUE(Says(message, "runcated")) << cut;
  }
  WriteBytes(File(3), bytes.substr(0, 400));
  EXPECT_TRUE(Says(Error(), "slice3"));
}

TEST_F(DicomTest, RefusesShortPixelData) {
  WriteSeries();
  DicomFile file = Slice(1);
  file.elements[0x7fe00010].second.resize(40);
  file.Write(File(3));
  EXPECT_TRUE(Says(Error(), "slice3"));
}

TEST_F(DicomTest, RefusesATiltedGantry) {
  for (int n = 0; n < 5; ++n) {
    DicomFile file = Slice(n);
    file.Position(10, -20 + 0.6 * n, 100 + 2 * n);
    file.Write(File(n));
  }
  EXPECT_TRUE(Says(Error(), "tilted by 16.7°"));
}

TEST_F(DicomTest, AsksWhichSeriesAndTakesTheChosenOne) {
  WriteSeries();
  for (int n = 0; n < 4; ++n) {
    DicomFile file = Slice(n);
    file.Text(0x0020000e, "UI", "1.2.3.5");
    file.Text(0x0008103e, "LO", "lung");
    file.Write(Path("b" + std::to_string(n)));
  }
  const std::string message = Error();
  EXPECT_TRUE(Says(message, "--series"));
  EXPECT_TRUE(Says(message, "1.2.3.5 (CT lung, 4 slices)"));
  EXPECT_EQ(Read("1.2.3.5").grid.size[2], 4);
  EXPECT_THROW(Read("1.2.3.6"), UsageError);
  EXPECT_EQ(ListSeries(folder_.string(), heard_).size(), 2u);
}

TEST_F(DicomTest, LeavesALocalizerOut) {
  WriteSeries();
  DicomFile scout(16, 16, 0, 9);
  scout.Text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
  scout.Write(Path("scout"));
  EXPECT_EQ(Read().grid.size[2], 5);
  EXPECT_TRUE(heard_.Heard("left out"));
}

TEST_F(DicomTest, NamesTheBrokenElement) {
  struct Broken {
    std::uint32_t tag;
    const char *vr, *value, *says;
  };
  for (const Broken& b : {Broken{0x00280030, "DS", "0\\0.5", "PixelSpacing"},
                          Broken{0x00280030, "DS", "-1\\0.5", "PixelSpacing"},
                          Broken{0x00280030, "DS", "nan\\0.5", "PixelSpacing"},
                          Broken{0x00280030, "DS", "", "PixelSpacing"},
                          Broken{0x00200032, "DS", "", "ImagePositionPatient"},
                          Broken{0x00200037, "DS", "1\\0\\0\\1\\0\\0", "ImageOrientation"},
                          Broken{0x00281053, "DS", "0", "RescaleSlope"},
                          Broken{0x00280008, "IS", "40", "NumberOfFrames"}}) {
    WriteSeries();
    DicomFile file = Slice(1);
    file.Text(b.tag, b.vr, b.value);
    file.Write(File(3));
    EXPECT_TRUE(Says(Error(), b.says));
  }
  WriteSeries();
  DicomFile colour = Slice(1);
  colour.Number(0x00280002, 3);
  colour.Write(File(3));
  EXPECT_TRUE(Says(Error(), "colour"));
}

TEST_F(DicomTest, RefusesFoldersWithoutAVolume) {
  EXPECT_TRUE(Says(Error(), "empty"));
  WriteBytes(Path("notes.txt"), "no image");
  EXPECT_TRUE(Says(Error(), "no DICOM image"));
  Slice(0).Write(File(0));
  EXPECT_TRUE(Says(Error(), "no volume"));
}

TEST_F(DicomTest, RefusesTwoVolumesInOneSeriesAndDropsCopies) {
  WriteSeries();
  Slice(2).Write(Path("copy"));
  EXPECT_EQ(Read().grid.size[2], 5);
  EXPECT_TRUE(heard_.Heard("the same image"));
  DicomFile phase = Slice(2);
  phase.Text(0x00080018, "UI", "1.2.3.4.77");
  phase.Write(Path("phase"));
  EXPECT_TRUE(Says(Error(), "same place"));
}

/// Five slices that are numbered and counted as a scanner does it: 1 to 5 downwards.
class DicomGapsTest : public DicomTest {
 protected:
  static constexpr std::uint32_t kNumber = 0x00200013, kAcquisition = 0x00200012,
                                 kInAcquisition = 0x00201002, kInSeries = 0x00201209;
  static DicomFile Numbered(int n, int number) {
    DicomFile file = Slice(n);
    file.Text(kNumber, "IS", std::to_string(number));
    return file;
  }
  void WriteNumbered(int first = 1, int step = 1) {
    for (int n = 0; n < 5; ++n) Numbered(n, first + step * (4 - n)).Write(File(n));
  }
  /// What is said when the folder is read.
  const std::vector<std::string>& Warnings() {
    heard_.warnings.clear();
    EXPECT_EQ(Read().grid.size[2], 5 - removed_);
    return heard_.warnings;
  }
  void Remove(int n) {
    std::filesystem::remove(File(n));
    ++removed_;
  }
  int removed_ = 0;
};

TEST_F(DicomGapsTest, AMissingFirstSliceIsSeenFromTheNumbers) {
  WriteNumbered();
  EXPECT_TRUE(Warnings().empty()) << Warnings().front();
  Remove(4);
  ASSERT_EQ(Warnings().size(), 1u);
  for (const std::string& part : {File(3), std::string("InstanceNumber (0020,0013) 2")})
    EXPECT_TRUE(Says(Warnings().front(), part));
}

TEST_F(DicomGapsTest, ALocalizerOfTheSameSeriesTakesNumbersToo) {
  WriteNumbered(2);
  EXPECT_TRUE(Says(Warnings().at(0), "InstanceNumber"));
  DicomFile scout(16, 16, 0, 9);
  scout.Text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
  scout.Text(kNumber, "IS", "1");
  scout.Write(Path("scout"));
  ASSERT_EQ(Warnings().size(), 1u);
  EXPECT_TRUE(Says(Warnings().front(), "left out"));
  // That of another series does not.
  scout.Text(0x0020000e, "UI", "1.2.3.5");
  scout.Write(Path("scout"));
  EXPECT_EQ(Warnings().size(), 2u);
  EXPECT_TRUE(heard_.Heard("InstanceNumber"));
}

TEST_F(DicomGapsTest, TheFileThatIsNamedHoldsTheNumberThatIsNamed) {
  WriteNumbered(5);
  DicomFile scout(16, 16, 0, 9);
  scout.Text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
  scout.Text(kNumber, "IS", "3");
  scout.Write(Path("scout"));
  Warnings();
  EXPECT_TRUE(heard_.Heard(Path("scout") + ": InstanceNumber (0020,0013) 3 is the lowest"));
}

TEST_F(DicomGapsTest, AMissingLastSliceIsSeenFromTheCounts) {
  const std::pair<std::uint32_t, const char*> counts[] = {
      {kInAcquisition, "ImagesInAcquisition (0020,1002) tells of 5 images, 4 are here"},
      {kInSeries, "NumberOfSeriesRelatedInstances (0020,1209) tells of 5 images, 4 are here"}};
  for (const auto& [tag, says] : counts) {
    removed_ = 0;
    for (int n = 0; n < 5; ++n) {
      DicomFile file = Numbered(n, 5 - n);
      file.Text(tag, "IS", "5");
      file.Write(File(n));
    }
    EXPECT_TRUE(Warnings().empty()) << Warnings().front();
    Remove(0);
    ASSERT_EQ(Warnings().size(), 1u) << says;
    EXPECT_TRUE(Says(Warnings().front(), says));
    EXPECT_TRUE(Says(Warnings().front(), File(1)));
    // A copy of a slice does not stand for the one that is missing.
    std::filesystem::copy(File(1), Path("copy"));
    Warnings();
    EXPECT_TRUE(heard_.Heard(says));
    std::filesystem::remove(Path("copy"));
  }
}

TEST_F(DicomGapsTest, CountsOfAnAcquisitionMayCoverSeveralSeriesOrAPartOfOne) {
  const auto write = [&](int n, const std::string& acquisition, const std::string& count) {
    DicomFile file = Numbered(n, 5 - n);
    file.Text(kAcquisition, "IS", acquisition);
    file.Text(kInAcquisition, "IS", count);
    file.Write(File(n));
  };
  // Step and shoot: two acquisitions make one series.
  for (int n = 0; n < 5; ++n) write(n, n < 2 ? "1" : "2", n < 2 ? "2" : "3");
  EXPECT_TRUE(Warnings().empty()) << Warnings().front();
  for (int n = 2; n < 5; ++n) write(n, "2", "4");
  ASSERT_EQ(Warnings().size(), 1u);
  EXPECT_TRUE(Says(Warnings().front(), "tells of 4 images, 3 are here"));
  // The fourth one is another reconstruction.
  DicomFile other = Numbered(0, 1);
  other.Text(kAcquisition, "IS", "2");
  other.Text(0x0020000e, "UI", "1.2.3.5");
  other.Text(0x00080018, "UI", "1.2.3.5.1");
  other.Write(Path("other"));
  ASSERT_EQ(Warnings().size(), 1u);
  EXPECT_TRUE(Says(Warnings().front(), "left out"));
}

TEST_F(DicomGapsTest, EverySecondSliceIsSeenFromTheNumbers) {
  WriteNumbered(1, 2);
  ASSERT_EQ(Warnings().size(), 1u);
  EXPECT_TRUE(Says(Warnings().front(), "goes on in steps of 2"));
}

TEST_F(DicomGapsTest, NumbersFarApartAreComparedAllTheSame) {
  const std::vector<int> number = {2147483647, -2147483647 - 1};
  for (int n = 0; n < 5; ++n) Numbered(n, number[n % 2]).Write(File(n));
  EXPECT_TRUE(Warnings().empty()) << "no steps: " << Warnings().front();
  // As far as even steps go. Three slices are the fewest that make a volume.
  for (int n = 0; n < 3; ++n)
    Numbered(n, n == 0 ? number[1] : n == 1 ? -1 : 2147483646).Write(File(n));
  for (int n = 3; n < 5; ++n) Remove(n);
  ASSERT_EQ(Warnings().size(), 1u);
  EXPECT_TRUE(Says(Warnings().front(), File(0)));
  EXPECT_TRUE(Says(Warnings().front(), "goes on in steps of 2147483647"));
}

TEST_F(DicomGapsTest, NumbersThatTellNothingAreNotWarnedOf) {
  WriteNumbered(0);
  EXPECT_TRUE(Warnings().empty()) << "some scanners begin at 0";
  for (const char* number : {"", "a", "99999999999"}) {
    DicomFile file = Slice(1);
    file.Text(kNumber, "IS", number);
    file.Write(File(1));
    EXPECT_TRUE(Warnings().empty()) << number << ": " << Warnings().front();
  }
  for (int n = 0; n < 5; ++n) {
    DicomFile file = Numbered(n, 5 - n);
    file.Text(kInAcquisition, "IS", "1");  // fewer than there are: counted in another way
    file.Write(File(n));
  }
  EXPECT_TRUE(Warnings().empty()) << Warnings().front();
}

TEST(DicomData, ReadsARealSeriesWithoutUids) {
  const std::string folder = testing::DataFolder() + "/ct-dicom";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  Listener heard;
  const Volume volume = ReadVolume(folder, {}, heard);
  EXPECT_EQ(volume.grid.size, Eigen::Vector3i(512, 512, 20));
  EXPECT_NEAR(volume.grid.spacing_mm[2], 2, 1e-6);
  EXPECT_TRUE(heard.Heard("UIDs are missing"));
  EXPECT_TRUE(heard.Heard("slice thickness 3.00 mm"));
  // Twenty slices out of a longer scan, numbered 267 to 286.
  EXPECT_TRUE(heard.Heard("InstanceNumber (0020,0013) 267 is the lowest"));
  EXPECT_EQ(heard.warnings.size(), 3u);
}

}  // namespace
}  // namespace kerf
