/// `kerf plan` as a person starts it, on files that are broken: exit status 3, and the message
/// names file and element.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>

#include "Adapters/Itk/VolumeFiles.h"
#include "CaseIO/Markups.h"
#include "Logic/CaseIO/TemporaryFolder.h"
#include "Logic/Itk/DicomFiles.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using testing::DicomFile;

class PlanCommand : public ::testing::Test {
 protected:
  /// @return exit status; what it said is in said_
  int Run(const std::string& arguments) {
    const std::string command = std::string("'") + KERF_BINARY + "' plan " + arguments +
                                " --output '" + folder_ / "case" + "' > '" + folder_ / "said.txt" +
                                "' 2>&1";
    const int status = std::system(command.c_str());
    said_ = folder_.Read("said.txt");
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  void Refuses(const std::string& input, const std::string& file, const std::string& element,
               const std::string& options = "") {
    EXPECT_EQ(Run("'" + input + "' --preset liver " + options), 3) << input << ": " << said_;
    EXPECT_NE(said_.find(file), std::string::npos) << said_;
    EXPECT_NE(said_.find(element), std::string::npos) << element << " is not in: " << said_;
    EXPECT_FALSE(fs::exists(folder_ / "case")) << "no half-written case";
  }

  /// Five slices; `change` may break slice 2. @return the folder
  std::string Series(const std::string& name,
                     const std::function<void(DicomFile*)>& change = nullptr) {
    const fs::path folder = folder_ / name;
    fs::create_directories(folder);
    for (int n = 0; n < 5; ++n) {
      DicomFile slice(8, 6, 100 + 2.0 * n, n);
      if (n == 2 && change) change(&slice);
      slice.Write(folder / ("slice" + std::to_string(n)));
    }
    return folder.string();
  }
  std::string Nifti(const std::string& name, const Vec3& spacing_mm) {
    Volume volume;
    volume.grid.size = {7, 5, 4};
    volume.grid.spacing_mm = spacing_mm;
    auto voxels = std::make_shared<std::vector<std::int16_t>>();
    for (int i = 0; i < 7 * 5 * 4; ++i) voxels->push_back(static_cast<std::int16_t>(60 + i));
    volume.voxels = voxels;
    WriteVolume(folder_ / name, volume);
    return folder_ / name;
  }
  /// A NIfTI volume with bytes of its header set.
  template <class T>
  std::string Nifti(const std::string& name, std::size_t offset, T value) {
    Nifti(name, Vec3(0.7, 1.1, 2.5));
    std::string bytes = folder_.Read(name);
    std::memcpy(&bytes[offset], &value, sizeof value);
    return folder_.Write(name, bytes);
  }
  testing::TemporaryFolder folder_;
  std::string said_;
};

TEST_F(PlanCommand, RefusesBrokenDicomFolders) {
  const std::string truncated = Series("truncated");
  fs::resize_file(fs::path(truncated) / "slice2", fs::file_size(truncated + "/slice2") - 40);
  Refuses(truncated, "slice2", "runcated");

  Refuses(Series("patients", [](DicomFile* f) { f->Text(0x00100020, "LO", "P2"); }), "slice2",
          "PatientID (0010,0020)");

  const std::string gap = Series("gap");
  fs::remove(fs::path(gap) / "slice2");
  Refuses(gap, "slice3", "1 slice(s) missing");

  Refuses(Series("colour",
                 [](DicomFile* f) {
                   f->Number(0x00280002, 3);
                   f->Text(0x00280004, "CS", "RGB");
                   f->elements[0x7fe00010].second.resize(8 * 6 * 6);
                 }),
          "slice2", "SamplesPerPixel");
  Refuses(Series("zero", [](DicomFile* f) { f->Text(0x00280030, "DS", "0\\0.75"); }), "slice2",
          "PixelSpacing");
  Refuses(Series("negative", [](DicomFile* f) { f->Text(0x00280030, "DS", "0.5\\-0.75"); }),
          "slice2", "PixelSpacing");
  Refuses(Series("nan", [](DicomFile* f) { f->Text(0x00280030, "DS", "nan\\0.75"); }), "slice2",
          "PixelSpacing");
  Refuses(Series("comma", [](DicomFile* f) { f->Text(0x00280030, "DS", "0,5\\0.75"); }), "slice2",
          "PixelSpacing");
  for (const std::string photometric : {"PALETTE COLOR", "MONOCHROME1"})
    Refuses(Series(photometric, [&](DicomFile* f) { f->Text(0x00280004, "CS", photometric); }),
            "slice2", "PhotometricInterpretation");
}

TEST_F(PlanCommand, SaysWhichOrganItTakesWhereThereAreSeveral) {
  const std::string ct = Nifti("body.nii", Vec3(40, 1.1, 2.5));
  WriteMarkups(folder_ / "seeds.mrk.json", {{"Fiducial", {{"organ", Vec3(-80, 0, 0)}}}});
  for (const std::string& options :
       {std::string(), "--seeds '" + folder_ / "seeds.mrk.json" + "'"}) {
    EXPECT_EQ(Run("'" + ct + "' " + options), 3) << said_;  // there is no liver in noise
    EXPECT_NE(said_.find("the liver is segmented"), std::string::npos) << said_;
  }
}

TEST_F(PlanCommand, AsksWhichOfSeveralSeries) {
  const std::string folder = Series("two");
  for (int n = 0; n < 4; ++n) {
    DicomFile slice(8, 6, 100 + 2.0 * n, 20 + n);
    slice.Text(0x0020000e, "UI", "1.2.3.5");
    slice.Write(fs::path(folder) / ("late" + std::to_string(n)));
  }
  Refuses(folder, "two", "SeriesInstanceUID");
  for (const char* part : {"1.2.3.4", "1.2.3.5", "--series", "5 slices", "4 slices"})
    EXPECT_NE(said_.find(part), std::string::npos) << part << " is not in: " << said_;
  EXPECT_EQ(Run("'" + folder + "' --preset liver --series 9.9.9"), 2) << said_;
  EXPECT_EQ(Run("'" + folder + "' --preset liver --series 1.2.3.5"), 3) << said_;
  EXPECT_EQ(said_.find("SeriesInstanceUID"), std::string::npos) << "read, and no liver in it";
}

TEST_F(PlanCommand, RefusesBrokenNifti) {
  Refuses(Nifti<std::int16_t>("flat.nii", 40, 2), "flat.nii", "dim[0]");
  Refuses(Nifti<float>("zero.nii", 80, 0.f), "zero.nii", "pixdim[1]");
  Refuses(Nifti<float>("negative.nii", 84, -1.1f), "negative.nii", "pixdim[2]");
  Refuses(Nifti<float>("nan.nii", 88, std::nanf("")), "nan.nii", "pixdim[3]");
  Refuses(Nifti<std::int16_t>("colour.nii", 70, 128), "colour.nii", "colour");
  const std::string four = Nifti<std::int16_t>("four.nii", 40, 4);
  std::string bytes = folder_.Read("four.nii");
  const std::int16_t times = 3;
  std::memcpy(&bytes[48], &times, 2);
  folder_.Write("four.nii", bytes);
  Refuses(four, "four.nii", "4-D");
  folder_.Write("cut.nii", folder_.Read("zero.nii").substr(0, 400));
  Refuses(folder_ / "cut.nii", "cut.nii", "");
}

TEST_F(PlanCommand, RefusesASeedOutsideTheVolume) {
  const std::string ct = Nifti<std::int16_t>("ct.nii", 40, 3);
  WriteMarkups(folder_ / "seeds.mrk.json", {{"Fiducial", {{"organ", Vec3(500, 0, 0)}}}});
  Refuses(ct, "seeds.mrk.json", "controlPoints[0]", "--seeds '" + folder_ / "seeds.mrk.json" + "'");
  EXPECT_NE(said_.find("outside the volume"), std::string::npos) << said_;
}

}  // namespace
}  // namespace kerf
