#include <gtest/gtest.h>

#include <cstring>

#include "Adapters/Itk/VolumeFiles.h"
#include "TestSupport.h"

namespace kerf {
namespace {

using testing::InputErrorOf;
using testing::Listener;
using testing::Says;

class VolumeFilesTest : public testing::FolderTest {
 protected:
  static Volume Oblique(bool left_handed) {
    Volume volume;
    volume.grid.size = Eigen::Vector3i(7, 5, 4);
    volume.grid.spacing_mm = Vec3(0.7, 1.1, 2.5);
    volume.grid.origin_mm = Vec3(-12.5, 34.25, -560);
    volume.grid.direction = (Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized())).toRotationMatrix();
    if (left_handed) volume.grid.direction.col(2) *= -1;
    auto voxels = std::make_shared<std::vector<std::int16_t>>();
    for (int i = 0; i < 7 * 5 * 4; ++i) voxels->push_back(std::int16_t(-1000 + 11 * i));
    volume.voxels = voxels;
    return volume;
  }
  /// Writes a .nii, sets bytes of its header and reads it.
  template <class T>
  std::string ErrorWith(std::size_t offset, T value, Listener* heard = nullptr) {
    const std::string path = Path("broken.nii");
    WriteVolume(path, Oblique(false));
    std::string bytes = ReadBytes(path);
    std::memcpy(&bytes[offset], &value, sizeof value);
    WriteBytes(path, bytes);
    Listener own;
    return InputErrorOf([&] { ReadVolume(path, {}, heard ? *heard : own); });
  }
  /// Writes an .nrrd or .mha, replaces a line of its header and reads it.
  std::string ErrorWithLine(const std::string& extension, const std::string& key,
                            const std::string& line) {
    const std::string path = Path("broken." + extension);
    WriteVolume(path, Oblique(false));
    std::string bytes = ReadBytes(path);
    const auto begin = bytes.find("\n" + key) + 1;
    EXPECT_NE(begin, 0u) << key;
    bytes.replace(begin, bytes.find('\n', begin) - begin, line);
    WriteBytes(path, bytes);
    return InputErrorOf([&] { ReadVolume(path); });
  }
};

TEST_F(VolumeFilesTest, RoundTripsObliqueAnisotropicAndLeftHanded) {
  for (const bool left_handed : {false, true})
    for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
      const Volume written = Oblique(left_handed);
      WriteVolume(Path(name), written);
      const Volume read = ReadVolume(Path(name));
      EXPECT_TRUE(read.grid.SameAs(written.grid, 1e-4)) << name << left_handed;
      EXPECT_EQ(*read.voxels, *written.voxels) << name;
      EXPECT_FALSE(std::filesystem::exists(Path(std::string(".partial-") + name)));
    }
}

TEST_F(VolumeFilesTest, RoundTripsLabelsAndSegmentations) {
  LabelMap labels;
  labels.grid = Oblique(false).grid;
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(labels.grid.VoxelCount(), 0);
  for (int i = 0; i < 20; ++i) (*voxels)[std::size_t(10 + i)] = std::uint8_t(i % 4);
  labels.voxels = voxels;
  for (const char* name : {"l.nii.gz", "l.nrrd", "l.seg.nrrd"}) {
    WriteLabelMap(Path(name), labels);
    const LabelMap read = ReadLabelMap(Path(name));
    EXPECT_TRUE(read.grid.SameAs(labels.grid, 1e-4)) << name;
    EXPECT_EQ(*read.voxels, *voxels) << name;
    EXPECT_EQ(read.names.at(2), "tumour");
  }
  const std::string header = ReadBytes(Path("l.seg.nrrd"));
  for (const char* key :
       {"space: left-posterior-superior", "Segment0_Name:=organ", "Segment1_Name:=tumour",
        "Segment2_Name:=internal", "Segment0_LabelValue:=1", "Segment2_LabelValue:=3",
        "Segment0_Layer:=0", "Segment1_Color:=", "Segment0_Extent:=", "Segment1_Tags:="})
    EXPECT_TRUE(Says(header.substr(0, 4000), key));
}

TEST_F(VolumeFilesTest, ReadsSegmentsByNameWhateverTheirValue) {
  LabelMap labels;
  labels.grid = Oblique(false).grid;
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(labels.grid.VoxelCount(), 0);
  (*voxels)[3] = 1;
  (*voxels)[4] = 2;
  labels.voxels = voxels;
  labels.names = {{1, "Tumor"}, {2, "gallbladder"}};
  WriteSegmentation(Path("s.seg.nrrd"), labels);
  const LabelMap read = ReadSegmentation(Path("s.seg.nrrd"));
  EXPECT_EQ((*read.voxels)[3], 2);
  EXPECT_GE((*read.voxels)[4], 4);
  EXPECT_EQ(read.names.at((*read.voxels)[4]), "gallbladder");
}

TEST_F(VolumeFilesTest, RefusesBrokenNiftiNamingTheField) {
  EXPECT_TRUE(Says(ErrorWith<std::int16_t>(40, 2), "dim[0]"));
  EXPECT_TRUE(Says(ErrorWith<std::int16_t>(46, 1), "dim[3]"));
  EXPECT_TRUE(Says(ErrorWith<std::int16_t>(46, -4), "dim[3]"));
  EXPECT_TRUE(Says(ErrorWith<float>(80, 0.f), "pixdim[1]"));
  EXPECT_TRUE(Says(ErrorWith<float>(84, -1.1f), "pixdim[2]"));
  EXPECT_TRUE(Says(ErrorWith<float>(88, std::nanf("")), "pixdim[3]"));
  EXPECT_TRUE(Says(ErrorWith<float>(88, 5.f), "contradict"));
  EXPECT_TRUE(Says(ErrorWith<float>(284, 3.f), "sform"));
  EXPECT_TRUE(Says(ErrorWith<std::int16_t>(70, 128), "colour"));
  EXPECT_TRUE(Says(ErrorWith<std::int32_t>(0, 77), "sizeof_hdr"));
  EXPECT_TRUE(Says(ErrorWith<std::int32_t>(344, 0), "Analyze"));
  const std::string path = Path("four.nii");
  WriteVolume(path, Oblique(false));
  std::string bytes = ReadBytes(path);
  const std::int16_t four[2] = {4, 3};
  std::memcpy(&bytes[40], &four[0], 2);
  std::memcpy(&bytes[48], &four[1], 2);
  WriteBytes(path, bytes);
  EXPECT_TRUE(Says(InputErrorOf([&] { ReadVolume(path); }), "4-D"));
}

TEST_F(VolumeFilesTest, RefusesTruncatedFiles) {
  for (const char* name : {"t.nii", "t.nii.gz", "t.nrrd", "t.mha"}) {
    WriteVolume(Path(name), Oblique(false));
    const std::string bytes = ReadBytes(Path(name));
    for (const std::size_t keep : {bytes.size() - 60, std::size_t(100), std::size_t(0)}) {
      WriteBytes(Path(name), bytes.substr(0, keep));
      EXPECT_TRUE(Says(InputErrorOf([&] { ReadVolume(Path(name)); }), name)) << keep;
    }
  }
}

TEST_F(VolumeFilesTest, RefusesBrokenNrrdAndMetaImage) {
  const std::string directions = "space directions: ";
  EXPECT_TRUE(
      Says(ErrorWithLine("nrrd", "space directions", directions + "(1,0,0) (0,1,0) (0,0,nan)"),
           "space directions"));
  EXPECT_TRUE(
      Says(ErrorWithLine("nrrd", "space directions", directions + "(1,0,0) (0,0,0) (0,0,1)"),
           "space directions"));
  EXPECT_TRUE(
      Says(ErrorWithLine("nrrd", "space directions", directions + "(1,0,0) (.5,1,0) (0,0,1)"),
           "sheared"));
  EXPECT_TRUE(Says(ErrorWithLine("nrrd", "sizes", "sizes: 7 20 1"), "sizes"));
  EXPECT_TRUE(Says(ErrorWithLine("nrrd", "kinds", "kinds: RGB-color domain domain"), "colour"));
  EXPECT_TRUE(
      Says(ErrorWithLine("mha", "ElementSpacing", "ElementSpacing = 1 0 1"), "ElementSpacing"));
  EXPECT_TRUE(
      Says(ErrorWithLine("mha", "ElementSpacing", "ElementSpacing = 1 -1 1"), "ElementSpacing"));
  EXPECT_TRUE(Says(ErrorWithLine("mha", "NDims", "NDims = 2"), "NDims"));
}

TEST_F(VolumeFilesTest, RefusesWhatIsNoVolume) {
  EXPECT_TRUE(Says(InputErrorOf([&] { ReadVolume(Path("none.nrrd")); }), "does not exist"));
  WriteBytes(Path("a.png"), "x");
  EXPECT_TRUE(Says(InputErrorOf([&] { ReadVolume(Path("a.png")); }), "extension"));
  WriteBytes(Path("a.nrrd"), "");
  EXPECT_TRUE(Says(InputErrorOf([&] { ReadVolume(Path("a.nrrd")); }), "empty"));
  WriteVolume(Path("b.nrrd"), Oblique(false));
  Listener silent;
  EXPECT_THROW(ReadVolume(Path("b.nrrd"), {"1.2.3"}, silent), UsageError);
  EXPECT_TRUE(Says(InputErrorOf([&] { ReadLabelMap(Path("b.nrrd")); }), "labels are integers"));
  EXPECT_TRUE(Says(InputErrorOf([&] { WriteVolume(Path("no/such/folder.nrrd"), Oblique(false)); }),
                   "cannot be written"));
}

TEST_F(VolumeFilesTest, WarnsWhereOrientationIsAssumed) {
  Listener heard;
  ErrorWith<std::int32_t>(252, 0, &heard);  // both qform_code and sform_code
  EXPECT_TRUE(heard.Heard("neither qform nor sform"));
}

}  // namespace
}  // namespace kerf
