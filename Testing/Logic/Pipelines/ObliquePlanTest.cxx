/// From an oblique CT of anisotropic voxels to the case's meshes, in patient coordinates. The files
/// are written by hand: what Kerf's own writer and reader both forgot would not be seen.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/CaseFolder.h"
#include "CaseIO/Markups.h"
#include "Logic/CaseIO/TemporaryFolder.h"
#include "Logic/Itk/DicomFiles.h"
#include "Pipelines/PlanPipeline.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryFolder;

/// An ellipsoid whose axes are neither the patient's nor the grid's, with a ball near one end.
struct Scene {
  GridGeometry grid;
  Vec3 center = Vec3(-42, 17, 233), half_mm = Vec3(34, 20, 27);
  Mat3 axes = Eigen::AngleAxisd(0.9, Vec3(3, -1, 1).normalized()).toRotationMatrix();
  Vec3 ball = center + 18 * axes.col(0);
  double ball_mm = 8;

  explicit Scene(bool left_handed) {
    grid.size = {64, 44, 38};
    grid.spacing_mm = Vec3(1.4, 1.9, 2.4);
    grid.direction = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    if (left_handed) grid.direction.col(2) *= -1;
    grid.origin_mm = center - grid.direction * Vec3(44, 42, 43);
  }
  int LabelAt(int i, int j, int k) const {
    const Vec3 p = grid.WorldFromIndex(Vec3(i, j, k));
    if ((axes.transpose() * (p - center)).cwiseQuotient(half_mm).norm() > 1) return 0;
    return (p - ball).norm() < ball_mm ? 2 : 1;
  }
  int HuAt(int i, int j, int k) const {
    const int hu[] = {-90, 120, 60};
    return hu[LabelAt(i, j, k)] + (7 * i + 11 * j + 13 * k) % 9 - 4;
  }
};

template <class T, class At>
std::string Voxels(const Scene& scene, At at) {
  std::string bytes;
  for (int k = 0; k < scene.grid.size[2]; ++k)
    for (int j = 0; j < scene.grid.size[1]; ++j)
      for (int i = 0; i < scene.grid.size[0]; ++i) {
        const T value = static_cast<T>(at(i, j, k));
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
      }
  return bytes;
}

std::string Triple(const Vec3& v) {
  char text[100];
  snprintf(text, sizeof text, "(%.9g,%.9g,%.9g)", v[0], v[1], v[2]);
  return text;
}

std::string Nrrd(const Scene& scene, bool ras, const char* type, const std::string& voxels) {
  const Vec3 sign = ras ? Vec3(-1, -1, 1) : Vec3(1, 1, 1);
  std::string header = std::string("NRRD0004\ntype: ") + type + "\ndimension: 3\nspace: " +
                       (ras ? "right-anterior-superior" : "left-posterior-superior") + "\nsizes:";
  for (int a = 0; a < 3; ++a) header += " " + std::to_string(scene.grid.size[a]);
  header += "\nspace directions:";
  for (int a = 0; a < 3; ++a)
    header +=
        " " + Triple(sign.cwiseProduct(scene.grid.direction.col(a)) * scene.grid.spacing_mm[a]);
  return header + "\nkinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: " +
         Triple(sign.cwiseProduct(scene.grid.origin_mm)) + "\n\n" + voxels;
}

/// Single file, sform only: index → RAS.
std::string Nifti(const Scene& scene, std::int16_t type, std::int16_t bits,
                  const std::string& voxels) {
  std::string h(352, '\0');
  const auto put = [&](std::size_t at, auto value) { std::memcpy(&h[at], &value, sizeof value); };
  put(0, std::int32_t(348));
  put(40, std::int16_t(3));
  put(70, type);
  put(72, bits);
  put(76, 1.f);
  put(108, 352.f);
  put(112, 1.f);
  put(123, char(2));          // mm
  put(254, std::int16_t(1));  // sform_code
  std::memcpy(&h[344], "n+1", 4);
  for (int a = 0; a < 3; ++a) {
    put(42 + 2 * a, std::int16_t(scene.grid.size[a]));
    put(80 + 4 * a, float(scene.grid.spacing_mm[a]));
    const double sign = a < 2 ? -1 : 1;
    for (int c = 0; c < 3; ++c)
      put(280 + 16 * a + 4 * c,
          float(sign * scene.grid.direction(a, c) * scene.grid.spacing_mm[c]));
    put(280 + 16 * a + 12, float(sign * scene.grid.origin_mm[a]));
  }
  return h + voxels;
}

/// Volume, centroid and second moment of a tetra mesh, exactly.
struct Moments {
  double volume_mm3 = 0;
  Vec3 center = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
};

Moments MomentsOf(const TetMesh& mesh) {
  Moments m;
  Mat3 second = Mat3::Zero();
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    Vec3 v[4], sum = Vec3::Zero();
    Mat3 squares = Mat3::Zero();
    for (int c = 0; c < 4; ++c) {
      v[c] = mesh.rest.row(mesh.tets(t, c)).transpose();
      sum += v[c];
      squares += v[c] * v[c].transpose();
    }
    const double volume = (v[1] - v[0]).cross(v[2] - v[0]).dot(v[3] - v[0]) / 6;
    m.volume_mm3 += volume;
    m.center += volume / 4 * sum;
    second += volume / 20 * (squares + sum * sum.transpose());
  }
  m.center /= m.volume_mm3;
  m.covariance = second / m.volume_mm3 - m.center * m.center.transpose();
  return m;
}

constexpr double kVolumeWithin = 0.01;  ///< found: 0.0002

/// The case's files against what is known of the patient.
void ExpectInPlace(const std::string& folder, const Scene& scene, double within_mm) {
  const CaseFolder opened = CaseFolder::Open(folder);
  const Moments organ = MomentsOf(ReadTetMesh(opened.Path("organ_mesh")));
  EXPECT_LT((organ.center - scene.center).norm(), within_mm) << organ.center.transpose();
  // Moments are quotients: they are the same where all tetrahedra are inverted, the volume is not.
  const double volume_mm3 = 4.0 / 3 * M_PI * scene.half_mm.prod();
  EXPECT_NEAR(organ.volume_mm3, volume_mm3, kVolumeWithin * volume_mm3);
  // Of an ellipsoid: half axis² / 5 along each axis, nothing across.
  const Mat3 along = 5 * scene.axes.transpose() * organ.covariance * scene.axes;
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(std::sqrt(along(a, a)), scene.half_mm[a], within_mm) << "half axis " << a;
    for (int b = 0; b < a; ++b)
      EXPECT_NEAR(along(a, b) / (scene.half_mm[a] * scene.half_mm[b]), 0, 0.03) << a << " " << b;
  }

  const SurfaceFile surface = ReadSurfaceFile(opened.Path("organ_surface"));
  EXPECT_EQ(surface.space, Space::LPS);
  const Points local = (surface.surface.points.rowwise() - scene.center.transpose()) * scene.axes;
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(local.col(a).maxCoeff(), scene.half_mm[a], 1.4) << a;
    EXPECT_NEAR(local.col(a).minCoeff(), -scene.half_mm[a], 1.4) << a;
  }

  const SurfaceMesh ball = ReadSurface(opened.Path("tumour"));
  EXPECT_LT((ball.points.colwise().mean().transpose() - scene.ball).norm(), within_mm);
  EXPECT_NEAR(ball.SignedVolume(), 4.0 / 3 * M_PI * std::pow(scene.ball_mm, 3),
              0.15 * 4.0 / 3 * M_PI * std::pow(scene.ball_mm, 3));

  EXPECT_TRUE(ReadVolume(opened.Path("ct")).grid.SameAs(scene.grid, 1e-4));
  EXPECT_TRUE(ReadSegmentation(opened.Path("segmentation")).grid.SameAs(scene.grid, 1e-4));
}

TEST(ObliquePlan, MeshesOfLabelsLieWhereThePatientIs) {
  Progress silent;
  for (const bool left_handed : {false, true}) {
    const Scene scene(left_handed);
    const auto label = [&](int i, int j, int k) { return scene.LabelAt(i, j, k); };
    const auto hu = [&](int i, int j, int k) { return scene.HuAt(i, j, k); };
    const std::string labels = Voxels<std::uint8_t>(scene, label),
                      ct = Voxels<std::int16_t>(scene, hu);
    for (const std::string kind : {"lps.nrrd", "ras.nrrd", "world.nii"}) {
      SCOPED_TRACE(kind + (left_handed ? " left-handed" : ""));
      const TemporaryFolder folder;
      const bool nifti = kind == "world.nii", ras = kind == "ras.nrrd";
      PlanRequest request;
      request.input = folder.Write("ct-" + kind,
                                   nifti ? Nifti(scene, 4, 16, ct) : Nrrd(scene, ras, "short", ct));
      request.labels_file = folder.Write(
          "labels-" + kind, nifti ? Nifti(scene, 2, 8, labels) : Nrrd(scene, ras, "uchar", labels));
      request.meshing.tetrahedra = 6000;
      WriteCase(Plan(request, silent), folder / "case");
      ExpectInPlace(folder / "case", scene, 0.5);
    }
  }
}

TEST(ObliquePlan, ASeriesSegmentedByTheCommandDoesToo) {
  const Scene scene(false);
  const TemporaryFolder folder;
  fs::create_directories(folder / "dicom");
  const auto& grid = scene.grid;
  const auto numbers = [](std::initializer_list<double> values) {
    std::string text;
    char part[32];
    for (const double v : values) {
      snprintf(part, sizeof part, "%s%.10g", text.empty() ? "" : "\\", v);
      text += part;
    }
    return text;
  };
  for (int k = 0; k < grid.size[2]; ++k) {
    testing::DicomFile slice(grid.size[0], grid.size[1], 0, k);
    const Vec3 at = grid.WorldFromIndex(Vec3(0, 0, k));
    const Mat3& d = grid.direction;
    slice.Text(0x00200032, "DS", numbers({at[0], at[1], at[2]}));
    slice.Text(0x00200037, "DS", numbers({d(0, 0), d(1, 0), d(2, 0), d(0, 1), d(1, 1), d(2, 1)}));
    slice.Text(0x00280030, "DS", numbers({grid.spacing_mm[1], grid.spacing_mm[0]}));
    slice.SetPixels(grid.size[0], grid.size[1],
                    [&](int i, int j) { return scene.HuAt(i, j, k) + 1024; });
    slice.Write(fs::path(folder / "dicom") / ("slice" + std::to_string(k)));
  }
  // Markups of Slicer in its own frame.
  const Vec3 seed = scene.center - 12 * scene.axes.col(0);
  folder.Write("seeds.mrk.json",
               "{\"markups\": [{\"type\": \"Fiducial\", \"coordinateSystem\": \"RAS\", "
               "\"controlPoints\": [{\"label\": \"organ\", \"position\": [" +
                   std::to_string(-seed[0]) + ", " + std::to_string(-seed[1]) + ", " +
                   std::to_string(seed[2]) + "]}]}]}");
  const std::string command = std::string("'") + KERF_BINARY + "' plan '" + folder / "dicom" +
                              "' --preset kidney --seeds '" + folder / "seeds.mrk.json" +
                              "' --tetrahedra 6000 --output '" + folder / "case" + "' > '" +
                              folder / "said.txt" + "' 2>&1";
  const int status = std::system(command.c_str());
  ASSERT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 0) << folder.Read("said.txt");
  ExpectInPlace(folder / "case", scene, 1.0);
}

}  // namespace
}  // namespace kerf
