#include "Adapters/Vtk/LabelMesh.h"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkUnstructuredGrid.h>

#include "Adapters/Vtk/Conversions.h"
#include "Adapters/Vtk/vtkKerfLabelMapToTetraGrid.h"

namespace kerf {

TetMesh MeshByFilter(const LabelMap& labels, const MeshingOptions& options, Progress& progress,
                     MeshingReport* report) {
  vtkNew<vtkKerfLabelMapToTetraGrid> mesher;
  mesher->SetInputData(ToVtk(labels));
  mesher->SetTetrahedra(options.tetrahedra);
  mesher->SetMinimumDihedral(options.min_dihedral_deg);
  mesher->SetSourceName(labels.source.c_str());
  mesher->SetProgressSink(&progress);
  mesher->Update();
  mesher->RethrowError();
  *report = mesher->GetReport();
  return TetMeshFromVtk(mesher->GetOutput(), labels.source);
}

}  // namespace kerf
