// Series compressed by GDCM, as an archive hands them out, read back voxel by voxel.
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>
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

constexpr int kColumns = 40, kRows = 24, kSlices = 4;

/// Smooth tissue with an edge and negative values: −1000 … 1200 HU.
int Hu(int i, int j, int k) { return i < 5 ? -1000 : 7 * i * (k + 1) - 11 * j + (i * j) % 13; }

class DicomCompressed : public testing::FolderTest {
 protected:
  /// GDCM's own JPEG 2000 has 16 bits where the header tells of 12, and it says so at each reading.
  static void SetUpTestSuite() { gdcm::Trace::WarningOff(); }
  std::string File(int k) const { return Path("slice" + std::to_string(k)); }
  /// @param is_signed 16 bits that hold HU as they are; otherwise 12 bits from −1024
  void WriteSeries(gdcm::TransferSyntax::TSType syntax, bool is_signed) {
    for (int k = 0; k < kSlices; ++k) {
      DicomFile file(kColumns, kRows, 100 + 2.0 * k, k);
      file.SetPixels(kColumns, kRows,
                     [&](int i, int j) { return Hu(i, j, k) + (is_signed ? 0 : 1024); });
      if (is_signed) {
        file.Text(0x00281052, "DS", "0");
        file.Number(0x00280101, 16);
        file.Number(0x00280102, 15);
        file.Number(0x00280103, 1);
      }
      file.Write(Path("raw"));
      Compress(Path("raw"), syntax, File(k));
    }
    std::filesystem::remove(Path("raw"));
  }
  static void Compress(const std::string& from, gdcm::TransferSyntax::TSType syntax,
                       const std::string& to) {
    gdcm::ImageReader reader;
    reader.SetFileName(from.c_str());
    ASSERT_TRUE(reader.Read());
    gdcm::ImageChangeTransferSyntax change;
    change.SetTransferSyntax(syntax);
    change.SetInput(reader.GetImage());
    ASSERT_TRUE(change.Change());
    gdcm::ImageWriter writer;
    writer.SetFile(reader.GetFile());
    writer.SetImage(change.GetOutput());
    writer.SetFileName(to.c_str());
    ASSERT_TRUE(writer.Write());
  }
  /// Takes bytes off the compressed data and writes a file that is whole in itself.
  static void Shorten(const std::string& path, std::size_t bytes) {
    gdcm::Reader reader;
    reader.SetFileName(path.c_str());
    ASSERT_TRUE(reader.Read());
    gdcm::DataSet& data = reader.GetFile().GetDataSet();
    const gdcm::DataElement pixels = data.GetDataElement(gdcm::Tag(0x7fe0, 0x0010));
    ASSERT_TRUE(pixels.GetSequenceOfFragments());
    gdcm::SmartPointer<gdcm::SequenceOfFragments> shorter = new gdcm::SequenceOfFragments;
    const gdcm::ByteValue* old = pixels.GetSequenceOfFragments()->GetFragment(0).GetByteValue();
    gdcm::Fragment fragment;
    fragment.SetByteValue(old->GetPointer(), std::uint32_t((old->GetLength() - bytes) & ~1u));
    shorter->AddFragment(fragment);
    gdcm::DataElement replaced = pixels;
    replaced.SetValue(*shorter);
    data.Replace(replaced);
    gdcm::Writer writer;
    writer.SetFile(reader.GetFile());
    writer.SetCheckFileMetaInformation(false);
    writer.SetFileName(path.c_str());
    ASSERT_TRUE(writer.Write());
  }
  static void ExpectEveryVoxel(const Volume& volume) {
    ASSERT_EQ(volume.grid.size, Eigen::Vector3i(kColumns, kRows, kSlices));
    for (int k = 0; k < kSlices; ++k)
      for (int j = 0; j < kRows; ++j)
        for (int i = 0; i < kColumns; ++i)
          ASSERT_EQ((*volume.voxels)[volume.grid.Offset(i, j, k)], Hu(i, j, k))
              << i << " " << j << " " << k;
  }
  Listener heard_;
};

TEST_F(DicomCompressed, Jpeg2000IsReadVoxelByVoxel) {
  for (const bool is_signed : {false, true}) {
    SCOPED_TRACE(is_signed ? "signed" : "unsigned");
    WriteSeries(gdcm::TransferSyntax::JPEG2000Lossless, is_signed);
    const std::string bytes = ReadBytes(File(0));
    EXPECT_TRUE(Says(bytes.substr(0, 400), "1.2.840.10008.1.2.4.90"));
    EXPECT_NE(bytes.find("\xff\x4f\xff\x51"), std::string::npos) << "no codestream";
    const Volume volume = ReadVolume(folder_.string(), {}, heard_);
    ExpectEveryVoxel(volume);
    EXPECT_TRUE(volume.grid.spacing_mm.isApprox(Vec3(0.75, 0.5, 2)));
    EXPECT_TRUE(volume.grid.origin_mm.isApprox(Vec3(10, -20, 100)));
    EXPECT_TRUE(heard_.warnings.empty()) << heard_.warnings.front();
  }
}

TEST_F(DicomCompressed, OtherLosslessSyntaxesAreReadToo) {
  for (const auto syntax :
       {gdcm::TransferSyntax::JPEGLosslessProcess14_1, gdcm::TransferSyntax::JPEGLSLossless,
        gdcm::TransferSyntax::RLELossless}) {
    WriteSeries(syntax, false);
    SCOPED_TRACE(syntax);
    ExpectEveryVoxel(ReadVolume(folder_.string(), {}, heard_));
  }
}

TEST_F(DicomCompressed, TruncatedJpeg2000IsRefused) {
  WriteSeries(gdcm::TransferSyntax::JPEG2000Lossless, false);
  Shorten(File(2), 0);
  EXPECT_EQ(InputErrorOf([&] { ReadVolume(folder_.string(), {}, heard_); }), "");
  Shorten(File(2), 60);
  const std::string message = InputErrorOf([&] { ReadVolume(folder_.string(), {}, heard_); });
  EXPECT_TRUE(Says(message, File(2)));
  EXPECT_TRUE(Says(message, "PixelData (7FE0,0010)"));
  EXPECT_TRUE(Says(message, "truncated: the compressed data have no end mark"));
}

}  // namespace
}  // namespace kerf
