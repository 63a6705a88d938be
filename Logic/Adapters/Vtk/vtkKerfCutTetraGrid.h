#pragma once

#include <vtkUnstructuredGridAlgorithm.h>

#include <string>

#include "Cutting/TetCutter.h"

/// Tetrahedral grid + separation surface → cut grid.
///
/// Port 0: vtkUnstructuredGrid of tetrahedra; at rest are its points, or its point array
/// `rest_position_mm` where it has one (then the points are the current positions). Port 1:
/// vtkPolyData, the whole separation surface at rest (patient LPS, mm). Output: the grid opened
/// along the surface (node snapping and local remeshing, no inverted or degenerate tetrahedra,
/// volume kept); point arrays are interpolated, cell arrays taken from the tetrahedron that holds
/// the new one's middle. Point array `rest_position_mm` and cell array `region` are always written.
/// Where nothing can be cut the grid passes through and GetReason() says why. The output can be cut
/// again: parts that are already open are skipped.
class vtkKerfCutTetraGrid : public vtkUnstructuredGridAlgorithm {
 public:
  static vtkKerfCutTetraGrid* New();
  vtkTypeMacro(vtkKerfCutTetraGrid, vtkUnstructuredGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Port 1.
  void SetSurfaceConnection(vtkAlgorithmOutput* surface) { SetInputConnection(1, surface); }
  void SetSurfaceData(vtkDataObject* surface) { SetInputData(1, surface); }

  /// A vertex nearer to the surface than this fraction of its edge is moved onto it (default 0.3).
  vtkSetClampMacro(SnapFraction, double, 0.0, 0.45);
  vtkGetMacro(SnapFraction, double);
  /// Smallest dihedral angle at rest, degrees, that a cut must leave (default 3).
  vtkSetClampMacro(MinimumDihedralAngle, double, 0.0, 20.0);
  vtkGetMacro(MinimumDihedralAngle, double);
  /// Smallest tetrahedron that a cut may make, in mean tetrahedra of the grid (default 1e-7).
  vtkSetClampMacro(MinimumVolumeShare, double, 0.0, 1.0);
  vtkGetMacro(MinimumVolumeShare, double);
  /// Most vertices and tetrahedra added for each tetrahedron with something to cut (default 4, 8).
  vtkSetClampMacro(MaximumNewVertices, double, 0.0, 100.0);
  vtkGetMacro(MaximumNewVertices, double);
  vtkSetClampMacro(MaximumNewTetrahedra, double, 0.0, 100.0);
  vtkGetMacro(MaximumNewTetrahedra, double);

  /// Of the last update: was anything cut, did a part of the surface stay uncut, and why (not).
  bool GetCut() const { return Report.done; }
  bool GetPartial() const { return Report.partial; }
  const char* GetReason() const { return Report.reason.c_str(); }
  int GetNumberOfComponents() const { return Report.components; }
  const kerf::CutReport& GetReport() const { return Report; }

 protected:
  vtkKerfCutTetraGrid();
  ~vtkKerfCutTetraGrid() override = default;
  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector** input,
                  vtkInformationVector* output) override;

 private:
  vtkKerfCutTetraGrid(const vtkKerfCutTetraGrid&) = delete;
  void operator=(const vtkKerfCutTetraGrid&) = delete;

  double SnapFraction = 0.3;
  double MinimumDihedralAngle = 3.0;
  double MinimumVolumeShare = 1e-7;
  double MaximumNewVertices = 4.0;
  double MaximumNewTetrahedra = 8.0;
  kerf::CutReport Report;
};
