/// kerf-cutting-pictures CASE FOLDER: the four pictures of docs/reference/cutting.md. The organ of
/// a case is cut half through, fully through, twice and partially in depth, its inner structure
/// with it; the sides are turned apart about the crack front so that one can look in.
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "Adapters/Rendering/VirtualDisplay.h"
#include "Adapters/Vtk/Conversions.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "Cutting/CutStructure.h"
#include "Cutting/ExtrudePolyline.h"
#include "Cutting/TetCutter.h"
#include "Geometry/EmbedPoints.h"

namespace kerf {
namespace {

constexpr double kBeyond_mm = 150;  // outside the organ on every side
constexpr double kGap_mm = 5, kSlope = 0.22;
constexpr double kBeside_mm = 3;
constexpr int kRounds = 8;
constexpr int kNoRendering = 77;  // exit status: nothing can be drawn here

/// Axes of the organ: 0 the longest, 2 the shortest.
struct OrganAxes {
  Vec3 center;
  Mat3 axis;  // columns
  explicit OrganAxes(const Points& points) {
    center = points.colwise().mean().transpose();
    const Points rest = points.rowwise() - center.transpose();
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(Mat3(rest.transpose() * rest));
    axis = eigen.eigenvectors().rowwise().reverse();
  }
  Vec3 Inside(const Vec3& p) const { return axis.transpose() * (p - center); }
  Vec3 Outside(const Vec3& p) const { return center + axis * p; }
};

/// S in the organ's axes: crosses the long axis at `at_mm`, comes from −axis 1 and from +axis 2.
struct Knife {
  double at_mm, tip_mm, depth_mm, tilt;
  CutSurface Surface(const OrganAxes& axes, double tip) const {
    Points line(2, 3), way(1, 3);
    line.row(0) = axes.Outside({at_mm, -kBeyond_mm, kBeyond_mm}).transpose();
    line.row(1) = axes.Outside({at_mm + tilt * (tip + kBeyond_mm), tip, kBeyond_mm}).transpose();
    way.row(0) = -axes.axis.col(2).transpose();
    return ExtrudePolyline(line, way, 0, kBeyond_mm - depth_mm, 2.5);
  }
  bool Complete() const { return tip_mm >= kBeyond_mm && depth_mm <= -kBeyond_mm; }
  double Ahead(const Vec3& inside) const {  // > 0 on the far side of S
    return inside[0] - at_mm - tilt * (inside[1] + kBeyond_mm);
  }
  /// How far the side of this point is moved away from S.
  double Opening_mm(const Vec3& inside) const {
    if (Complete()) return kGap_mm;
    const double behind = depth_mm > -kBeyond_mm ? inside[2] - depth_mm : tip_mm - inside[1];
    return kSlope * std::max(0.0, behind);
  }
};

Points OpenedForView(const TetMesh& mesh, const OrganAxes& axes, const std::vector<Knife>& knives) {
  Points positions = mesh.rest;
  for (const Knife& knife : knives) {
    // Away from S the place tells the side; beside it what the vertex hangs on does, so that chips
    // go with the side that they stayed on.
    Eigen::VectorXd side = Eigen::VectorXd::Zero(mesh.VertexCount());
    for (Index v = 0; v < mesh.VertexCount(); ++v) {
      const double ahead = knife.Ahead(axes.Inside(mesh.rest.row(v).transpose()));
      if (std::abs(ahead) > kBeside_mm) side[v] = ahead;
    }
    const Eigen::VectorXd sure = side;
    for (int round = 0; round < kRounds; ++round) {
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.VertexCount());
      for (Index t = 0; t < mesh.TetCount(); ++t)
        for (int k = 0; k < 4; ++k)
          for (int j = 0; j < 4; ++j) sum[mesh.tets(t, k)] += 0.1 * side[mesh.tets(t, j)];
      side = (sure.array() != 0).select(sure, sum);
    }
    for (Index v = 0; v < mesh.VertexCount(); ++v) {
      const double mm = knife.Opening_mm(axes.Inside(mesh.rest.row(v).transpose()));
      positions.row(v) += ((side[v] > 0 ? mm : -mm) * axes.axis.col(0)).transpose();
    }
  }
  return positions;
}

/// Boundary triangles that a knife made, or the others.
SurfaceMesh Faces(const TetMesh& mesh, const Points& positions, const OrganAxes& axes,
                  const std::vector<Knife>& knives, bool cut) {
  SurfaceMesh faces;
  faces.points = positions;
  const Triangles all = BoundaryFaces(mesh.tets);
  faces.triangles.resize(all.rows(), 3);
  Index n = 0;
  for (Index f = 0; f < all.rows(); ++f) {
    Vec3 p[3];
    for (int k = 0; k < 3; ++k) p[k] = axes.Inside(mesh.rest.row(all(f, k)).transpose());
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    const bool made = std::any_of(knives.begin(), knives.end(), [&](const Knife& knife) {
      const Vec3 across = Vec3(1, -knife.tilt, 0).normalized();
      return std::abs(normal.dot(across)) > 0.8 &&
             std::abs(knife.Ahead((p[0] + p[1] + p[2]) / 3)) < 1.0;
    });
    if (made == cut) faces.triangles.row(n++) = all.row(f);
  }
  faces.triangles.conservativeResize(n, 3);
  return faces;
}

void Add(vtkRenderer* renderer, const SurfaceMesh& surface, const Vec3& colour, double opacity,
         bool edges) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(ToVtk(surface));
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(colour[0], colour[1], colour[2]);
  actor->GetProperty()->SetOpacity(opacity);
  actor->GetProperty()->SetInterpolationToFlat();
  actor->GetProperty()->SetEdgeVisibility(edges);
  actor->GetProperty()->SetEdgeColor(0.35, 0.12, 0.1);
  renderer->AddActor(actor);
}

/// False where the cuts do not give `pieces` or the picture is not written.
bool Picture(const TetMesh& organ, const SurfaceMesh& internal, const std::vector<Knife>& knives,
             int pieces, const std::string& path) {
  const OrganAxes axes(organ.rest);
  TetMesh mesh = organ;
  Structure calyces{"internal", internal, EmbedPoints(organ, internal.points)};
  for (const Knife& knife : knives) {
    TetCutter cutter;
    for (double tip = -40; tip < knife.tip_mm + 10; tip += 10) {
      const CutSurface s = knife.Surface(axes, std::min(tip, knife.tip_mm));
      CutReport report;
      const TopologyChange change = cutter.Cut(mesh, s, &report);
      if (!change.changed) continue;
      calyces = CutStructureSurface(calyces, s, change, mesh, StructureCutMode::Split);
      mesh = change.mesh;
    }
  }
  const MeshQuality quality = MeasureQuality(mesh, mesh.rest);
  std::printf("%s: %d pieces, %d tetrahedra (%d before), smallest angle %.1f deg\n", path.c_str(),
              quality.components, mesh.TetCount(), organ.TetCount(), quality.smallest_dihedral_deg);
  const Points positions = OpenedForView(mesh, axes, knives);
  SurfaceMesh inside = calyces.rest;
  inside.points = calyces.embedding.Positions(positions, mesh.tets);

  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  renderer->SetUseDepthPeeling(true);
  renderer->SetOcclusionRatio(0);
  renderer->SetMaximumNumberOfPeels(60);
  Add(renderer, Faces(mesh, positions, axes, knives, false), {0.85, 0.62, 0.52}, 0.3, false);
  Add(renderer, Faces(mesh, positions, axes, knives, true), {0.75, 0.25, 0.22}, 0.75, true);
  Add(renderer, inside, {0.95, 0.8, 0.25}, 1, false);
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(true);
  window->SetAlphaBitPlanes(true);
  window->SetMultiSamples(0);
  window->SetSize(800, 520);
  window->AddRenderer(renderer);
  const Vec3 from = axes.Outside({-60, -120, 140}), up = axes.axis.col(1);
  renderer->GetActiveCamera()->SetFocalPoint(axes.center.data());
  renderer->GetActiveCamera()->SetPosition(from.data());
  renderer->GetActiveCamera()->SetViewUp(up.data());
  renderer->ResetCamera();
  renderer->GetActiveCamera()->Zoom(1.5);
  window->Render();
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(window);
  image->ReadFrontBufferOff();
  vtkNew<vtkPNGWriter> writer;
  writer->SetFileName(path.c_str());
  writer->SetInputConnection(image->GetOutputPort());
  writer->Write();
  return quality.components == pieces && writer->GetErrorCode() == 0;
}

int Run(const std::string& root, const std::string& folder) {
  std::string why;
  if (!RenderingAvailable(&why)) {
    std::fprintf(stderr, "%s\n", why.c_str());
    return kNoRendering;
  }
  const TetMesh organ = ReadTetMesh(root + "/organ.vtu");
  const SurfaceMesh internal = ReadSurface(root + "/internal.vtp");
  const double all = kBeyond_mm;
  bool good = Picture(organ, internal, {{4, 0, -all, 0}}, 1, folder + "/cut-half.png");
  good &= Picture(organ, internal, {{4, all, -all, 0}}, 2, folder + "/cut-full.png");
  good &= Picture(organ, internal, {{-16, all, -all, 0}, {-8, all, -all, 0.15}}, 3,
                  folder + "/cut-twice.png");
  good &= Picture(organ, internal, {{4, all, 0, 0}}, 1, folder + "/cut-depth.png");
  EndVirtualDisplay();
  return good ? 0 : 1;
}

}  // namespace
}  // namespace kerf

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s CASE FOLDER\n", argv[0]);
    return 2;
  }
  return kerf::Run(argv[1], argv[2]);
}
