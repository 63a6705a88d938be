#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "Adapters/Vtk/MeshFiles.h"
#include "Core/Errors.h"
#include "Support/CasesFolder.h"
#include "Support/TestMeshes.h"

using namespace kerf;
namespace fs = std::filesystem;

namespace {

class MeshFiles : public ::testing::Test {
 protected:
  MeshFiles()
      : folder_(fs::temp_directory_path() / ("kerf-mesh-files-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~MeshFiles() override { fs::remove_all(folder_); }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string Bytes(const std::string& path) const {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void Write(const std::string& path, const std::string& bytes) const {
    std::ofstream(path, std::ios::binary) << bytes;
  }
  std::size_t FileCount() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator{});
  }
  fs::path folder_;
};

/// Asymmetric, so that a flip or a mirror shows.
SurfaceMesh Egg() {
  SurfaceMesh egg = kerf::testing::SphereSurface({10, -20, 35}, 8, 2);
  egg.points.col(0) += 0.3 * egg.points.col(1);
  return egg;
}

}  // namespace

TEST_F(MeshFiles, EveryFormatReadsBackInBothSpacesAndIsTagged) {
  const SurfaceMesh egg = Egg();
  for (const std::string extension : {"vtp", "stl", "ply", "obj"})
    for (const Space space : {Space::LPS, Space::RAS}) {
      const std::string path = Path("egg." + extension);
      WriteSurface(egg, path, space);
      const SurfaceFile back = ReadSurfaceFile(path);
      EXPECT_EQ(back.space, space) << extension;
      ASSERT_EQ(back.surface.points.rows(), egg.points.rows()) << extension;
      EXPECT_EQ(back.surface.triangles.rows(), egg.triangles.rows());
      EXPECT_NEAR(back.surface.SignedVolume(), egg.SignedVolume(), 1e-2) << extension;
      EXPECT_TRUE(back.surface.IsClosedManifold()) << extension;
      // .stl numbers its points in order of use; the shape is the same.
      const Eigen::RowVector3d center = egg.points.colwise().mean();
      EXPECT_LT((back.surface.points.colwise().mean() - center).norm(), 1e-4) << extension;
      if (extension != "stl") {
        EXPECT_LT((back.surface.points - egg.points).cwiseAbs().maxCoeff(), 1e-6) << extension;
      }
      // Never lost: the tag stands in the file as text.
      EXPECT_NE(Bytes(path).find("SPACE"), std::string::npos) << extension;
      if (extension != "vtp") {
        EXPECT_NE(Bytes(path).find(std::string("SPACE=") + ToString(space)), std::string::npos);
      }
    }
}

TEST_F(MeshFiles, RasIsATurnNotAMirror) {
  const SurfaceMesh egg = Egg();
  WriteSurface(egg, Path("egg.obj"), Space::RAS);
  std::string text = Bytes(Path("egg.obj"));
  text.replace(text.find("SPACE=RAS"), 9, "SPACE=LPS");
  Write(Path("egg.obj"), text);
  const SurfaceMesh raw = ReadSurface(Path("egg.obj"));
  EXPECT_NEAR(raw.points(5, 0), -egg.points(5, 0), 1e-6);
  EXPECT_NEAR(raw.points(5, 1), -egg.points(5, 1), 1e-6);
  EXPECT_NEAR(raw.points(5, 2), egg.points(5, 2), 1e-6);
  EXPECT_GT(raw.SignedVolume(), 0.0);
}

TEST_F(MeshFiles, UntaggedMeansLpsAndUnknownSpaceIsRefused) {
  WriteSurface(Egg(), Path("egg.ply"));
  const std::string text = Bytes(Path("egg.ply"));
  const auto at = text.find("comment SPACE=LPS\n");
  Write(Path("untagged.ply"), text.substr(0, at) + text.substr(at + 18));
  EXPECT_EQ(ReadSurfaceFile(Path("untagged.ply")).space, Space::LPS);
  std::string odd = text;
  odd.replace(odd.find("SPACE=LPS"), 9, "SPACE=XYZ");
  Write(Path("odd.ply"), odd);
  EXPECT_THROW(ReadSurface(Path("odd.ply")), InputError);
}

TEST_F(MeshFiles, RestPositionsTravelWithTheSurfaceAndTurnWithIt) {
  const SurfaceMesh egg = Egg();
  const Points rest = egg.points * 0.9;
  for (const Space space : {Space::LPS, Space::RAS}) {
    WriteSurface(egg, Path("egg.vtp"), space, &rest);
    const SurfaceFile back = ReadSurfaceFile(Path("egg.vtp"));
    ASSERT_TRUE(back.rest_position);
    EXPECT_LT((*back.rest_position - rest).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST_F(MeshFiles, TetMeshReadsBackExactly) {
  TetMesh mesh = kerf::testing::BoxMesh({10, 8, 6}, 3, 3, 3);
  kerf::testing::PaintSphere({0, 0, 0}, 3, Label::Tumour, &mesh);
  const Points moved = mesh.rest.rowwise() + Eigen::RowVector3d(1, 2, 3);
  for (const Space space : {Space::LPS, Space::RAS}) {
    const std::string path = Path("organ.vtu");
    WriteTetMesh(mesh, moved, path, space);
    Points positions;
    const TetMesh back = ReadTetMesh(path, &positions);
    EXPECT_EQ(back.tets, mesh.tets);
    EXPECT_EQ(back.region, mesh.region);
    EXPECT_LT((back.rest - mesh.rest).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((positions - moved).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST_F(MeshFiles, LegacyFilesAreWrittenTaggedAndNotRead) {
  const TetMesh mesh = kerf::testing::BoxMesh({10, 8, 6}, 2, 2, 2);
  WriteTetMesh(mesh, mesh.rest, Path("organ.vtk"), Space::RAS);
  WriteSurface(Egg(), Path("egg.vtk"));
  EXPECT_NE(Bytes(Path("organ.vtk")).find("SPACE=RAS"), std::string::npos);
  EXPECT_NE(Bytes(Path("egg.vtk")).find("SPACE=LPS"), std::string::npos);
  EXPECT_THROW(ReadSurface(Path("egg.vtk")), InputError);
  EXPECT_THROW(ReadTetMesh(Path("organ.vtk")), InputError);
}

TEST_F(MeshFiles, GlbIsInMetresAndYUp) {
  const SurfaceMesh egg = Egg();
  WriteSurface(egg, Path("egg.glb"));
  const std::string bytes = Bytes(Path("egg.glb"));
  ASSERT_EQ(bytes.substr(0, 4), "glTF");
  std::uint32_t length = 0, json_length = 0;
  std::memcpy(&length, bytes.data() + 8, 4);
  std::memcpy(&json_length, bytes.data() + 12, 4);
  EXPECT_EQ(length, bytes.size());
  const auto scene = nlohmann::json::parse(bytes.substr(20, json_length));
  const auto low = scene["accessors"][0]["min"], high = scene["accessors"][0]["max"];
  EXPECT_NEAR(low[0].get<double>(), 0.001 * egg.points.col(0).minCoeff(), 1e-6);
  EXPECT_NEAR(high[1].get<double>(), 0.001 * egg.points.col(2).maxCoeff(), 1e-6);
  EXPECT_NEAR(low[2].get<double>(), -0.001 * egg.points.col(1).maxCoeff(), 1e-6);
  EXPECT_EQ(scene["accessors"][0]["count"].get<Index>(), egg.points.rows());
}

TEST_F(MeshFiles, TruncatedFilesAreRefusedAtEveryLength) {
  const SurfaceMesh egg = Egg();
  for (const std::string extension : {"vtp", "stl", "ply"}) {
    const std::string path = Path("egg." + extension), cut = Path("cut." + extension);
    WriteSurface(egg, path);
    const std::string bytes = Bytes(path);
    for (const double part : {0.0, 0.01, 0.2, 0.5, 0.8, 0.95}) {
      Write(cut, bytes.substr(0, static_cast<std::size_t>(part * bytes.size())));
      EXPECT_THROW(ReadSurface(cut), InputError) << extension << " " << part;
    }
  }
  TetMesh mesh = kerf::testing::BoxMesh({10, 8, 6}, 3, 3, 3);
  WriteTetMesh(mesh, mesh.rest, Path("organ.vtu"));
  const std::string bytes = Bytes(Path("organ.vtu"));
  for (const double part : {0.0, 0.1, 0.5, 0.9}) {
    Write(Path("cut.vtu"), bytes.substr(0, static_cast<std::size_t>(part * bytes.size())));
    EXPECT_THROW(ReadTetMesh(Path("cut.vtu")), InputError) << part;
  }
}

TEST_F(MeshFiles, GarbageIsRefusedNamingTheFile) {
  std::string garbage = "solid nonsense";
  for (int i = 0; i < 3000; ++i) garbage += static_cast<char>((i * 7919) % 251);
  for (const std::string name : {"g.vtp", "g.stl", "g.ply", "g.obj", "g.vtk", "g.xyz"}) {
    Write(Path(name), garbage);
    try {
      ReadSurface(Path(name));
      FAIL() << name;
    } catch (const InputError& error) {
      EXPECT_EQ(error.File(), Path(name));
    }
  }
  EXPECT_THROW(ReadTetMesh(Path("g.vtp")), InputError);
  EXPECT_THROW(ReadSurface(Path("missing.stl")), InputError);
}

TEST_F(MeshFiles, BrokenElementsAreNamed) {
  Write(Path("i.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
  try {
    ReadSurface(Path("i.obj"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.Element(), "line 4");
  }
  Write(Path("n.obj"), "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_THROW(ReadSurface(Path("n.obj")), InputError);
  Write(Path("a.ply"),
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 5\n");
  try {
    ReadSurface(Path("a.ply"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.Element(), "face 0");
  }
  Write(Path("h.ply"), "ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n");
  EXPECT_THROW(ReadSurface(Path("h.ply")), InputError);
}

TEST_F(MeshFiles, AsciiStlIsRead) {
  Write(Path("a.stl"),
        "solid SPACE=RAS\nfacet normal 0 0 1\nouter loop\nvertex 1 2 3\nvertex 2 2 3\n"
        "vertex 1 3 3\nendloop\nendfacet\nendsolid\n");
  const SurfaceMesh surface = ReadSurface(Path("a.stl"));
  ASSERT_EQ(surface.triangles.rows(), 1);
  EXPECT_EQ(Vec3(surface.points.row(0).transpose()), Vec3(-1, -2, 3));
}

TEST_F(MeshFiles, WritingLeavesOneFileAndFailsWithTheName) {
  WriteSurface(Egg(), Path("egg.vtp"));
  EXPECT_EQ(FileCount(), 1U);
  EXPECT_THROW(WriteSurface(Egg(), Path("egg.xyz")), UsageError);
  EXPECT_THROW(WriteSurface(Egg(), "/proc/nowhere/egg.stl"), InputError);
  EXPECT_EQ(FileCount(), 1U);
}

TEST_F(MeshFiles, ReadsTheStudiesFiles) {
  const std::string cases = kerf::testing::CasesFolder().string();
  const std::string vtp = cases + "/kidney-1/truth/rest_internal.vtp",
                    stl = cases + "/silicone-left/organ_surface.stl";
  if (!fs::exists(vtp) || !fs::exists(stl)) GTEST_SKIP() << "no studies at " << cases;
  const SurfaceFile internal = ReadSurfaceFile(vtp);
  EXPECT_EQ(internal.space, Space::RAS);
  EXPECT_EQ(internal.surface.points.rows(), 1800);
  const SurfaceFile band = ReadSurfaceFile(stl);
  EXPECT_EQ(band.space, Space::RAS);
  EXPECT_TRUE(band.surface.IsClosedManifold());
  EXPECT_NEAR(band.surface.SignedVolume(), 120 * 30 * 4, 1.0);
}
