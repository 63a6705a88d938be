#pragma once

#include <vtkUnstructuredGridAlgorithm.h>

#include <exception>

#include "Meshing/TetMesher.h"

/// Label map → tetrahedral grid.
///
/// Input: vtkImageData with one scalar per voxel, 1 organ, 2 tumour, 3 inner structure; origin,
/// spacing and direction matrix in patient LPS, mm. Output: vtkUnstructuredGrid of tetrahedra that
/// fills the three labels as one organ without cavities; cell array `region` (1 organ, 2 tumour),
/// point array `rest_position_mm`. The surface is smooth below voxel size and encloses the voxels'
/// volume. Deterministic.
class vtkKerfLabelMapToTetraGrid : public vtkUnstructuredGridAlgorithm {
 public:
  static vtkKerfLabelMapToTetraGrid* New();
  vtkTypeMacro(vtkKerfLabelMapToTetraGrid, vtkUnstructuredGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Wanted number of tetrahedra, met within about 15 %. Default 15000.
  vtkSetClampMacro(Tetrahedra, int, 100, 10000000);
  vtkGetMacro(Tetrahedra, int);
  /// Smallest dihedral angle that is worked for, degrees. Default 8.
  vtkSetClampMacro(MinimumDihedral, double, 0.0, 20.0);
  vtkGetMacro(MinimumDihedral, double);
  /// Name of the input in messages. Default "label map".
  vtkSetStdStringFromCharMacro(SourceName);
  vtkGetCharFromStdStringMacro(SourceName);

  /// Where warnings and progress go beside VTK's own events; not owned, may be null.
  void SetProgressSink(kerf::Progress* sink) { Sink = sink; }
  /// Quality of the last mesh.
  const kerf::MeshingReport& GetReport() const { return Report; }
  /// VTK's pipeline carries no exceptions: a failed update leaves an empty output and an error
  /// event; this throws what went wrong (kerf::InputError, kerf::Cancelled …), or does nothing
  /// after a good one.
  void RethrowError() const;

 protected:
  vtkKerfLabelMapToTetraGrid() = default;
  ~vtkKerfLabelMapToTetraGrid() override = default;
  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector** input,
                  vtkInformationVector* output) override;

 private:
  vtkKerfLabelMapToTetraGrid(const vtkKerfLabelMapToTetraGrid&) = delete;
  void operator=(const vtkKerfLabelMapToTetraGrid&) = delete;

  int Tetrahedra = 15000;
  double MinimumDihedral = 8.0;
  std::string SourceName = "label map";
  kerf::Progress* Sink = nullptr;
  kerf::MeshingReport Report;
  std::exception_ptr Error;
};
