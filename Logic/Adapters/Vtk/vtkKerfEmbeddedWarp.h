#pragma once

#include <vtkPolyDataAlgorithm.h>

#include "Core/Embedding.h"
#include "Geometry/EmbedPoints.h"

/// Surface at rest + deformed tetrahedral grid → deformed surface.
///
/// Port 0: vtkPolyData at rest (patient LPS, mm). Port 1: vtkUnstructuredGrid of tetrahedra in
/// current coordinates with the point array `rest_position_mm`. Output: the surface of port 0, its
/// points carried along by their barycentric weights (exact for affine deformations), its own rest
/// positions as point array `rest_position_mm`; other arrays and all cells pass through. The
/// embedding is kept while the surface and the grid's rest and cells stay the same, so that a
/// moving grid costs a weighted sum per point.
class vtkKerfEmbeddedWarp : public vtkPolyDataAlgorithm {
 public:
  static vtkKerfEmbeddedWarp* New();
  vtkTypeMacro(vtkKerfEmbeddedWarp, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Port 1.
  void SetGridConnection(vtkAlgorithmOutput* grid) { SetInputConnection(1, grid); }
  void SetGridData(vtkDataObject* grid) { SetInputData(1, grid); }
  /// Points of the surface outside the grid at rest (bound to the nearest tetrahedron) in the last
  /// update.
  vtkIdType GetNumberOfPointsOutside() const { return Report.outside; }
  /// How often the embedding was computed: stays while only positions change.
  vtkGetMacro(EmbeddingCount, int);

 protected:
  vtkKerfEmbeddedWarp();
  ~vtkKerfEmbeddedWarp() override = default;
  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector** input,
                  vtkInformationVector* output) override;

 private:
  vtkKerfEmbeddedWarp(const vtkKerfEmbeddedWarp&) = delete;
  void operator=(const vtkKerfEmbeddedWarp&) = delete;

  kerf::Points SurfaceRest, GridRest;
  kerf::Tets Tets;
  kerf::Embedding Embedding;
  kerf::EmbeddingReport Report;
  int EmbeddingCount = 0;
};
