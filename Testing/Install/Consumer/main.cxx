// A program of someone else's: cuts one cube in two, holds one half, pulls the other, writes VTK.
#include <vtkUnstructuredGrid.h>

#include <cstdio>

#include "Adapters/Vtk/Conversions.h"
#include "Cutting/ExtrudePolyline.h"
#include "Cutting/TetCutter.h"
#include "Mechanics/ElasticSolver.h"

namespace {

kerf::TetMesh Cube(double side_mm, int n) {
  kerf::TetMesh mesh;
  const int m = n + 1;
  mesh.rest.resize(m * m * m, 3);
  for (int z = 0; z < m; ++z)
    for (int y = 0; y < m; ++y)
      for (int x = 0; x < m; ++x)
        mesh.rest.row((z * m + y) * m + x) = Eigen::RowVector3d(x, y, z) * side_mm / n;
  const int path[6][3] = {{1, 2, 4}, {2, 1, 4}, {2, 4, 1}, {4, 2, 1}, {4, 1, 2}, {1, 4, 2}};
  mesh.tets.resize(6 * n * n * n, 4);
  int t = 0;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (const auto& p : path) {
          int corner = 0;
          for (int k = 0; k < 4; ++k) {
            if (k > 0) corner |= p[k - 1];
            mesh.tets(t, k) =
                ((z + (corner >> 2 & 1)) * m + y + (corner >> 1 & 1)) * m + x + (corner & 1);
          }
          if (kerf::TetVolume(mesh.rest, mesh.tets, t) < 0) {
            const kerf::Index keep = mesh.tets(t, 2);
            mesh.tets(t, 2) = mesh.tets(t, 3);
            mesh.tets(t, 3) = keep;
          }
          ++t;
        }
  mesh.region.assign(mesh.tets.rows(), 1);
  return mesh;
}

}  // namespace

int main() {
  const kerf::TetMesh cube = Cube(20.0, 4);
  kerf::CutPolyline line;
  line.points.resize(2, 3);
  line.points << 9.3, -1.0, 20.0, 9.3, 21.0, 20.0;
  kerf::TetCutter cutter;
  kerf::CutReport report;
  const auto change =
      cutter.Cut(cube, kerf::ExtrudePolyline(line, {0, 0, -1}, 2.0, 22.0, 2.0), &report);
  if (!report.done || report.components != 2) {
    std::printf("not cut in two: %s\n", report.reason.c_str());
    return 1;
  }
  const auto grid = kerf::ToVtk(change.mesh);
  const auto solver = kerf::MakeKerfSolver();
  std::printf("%d pieces, %lld cells\n", report.components,
              static_cast<long long>(grid->GetNumberOfCells()));
  return solver && grid->GetNumberOfCells() == change.mesh.TetCount() ? 0 : 1;
}
