#include "Adapters/Vtk/vtkKerfCutTetraGrid.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkIdList.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include "Adapters/Vtk/Conversions.h"

vtkStandardNewMacro(vtkKerfCutTetraGrid);

namespace {

/// Point arrays by the weights of the parents, cell arrays from the parent tetrahedron. Arrays that
/// the output has are left alone.
void CarryOver(const kerf::TopologyChange& change, vtkUnstructuredGrid* from,
               vtkUnstructuredGrid* to) {
  vtkNew<vtkPointData> points;
  vtkNew<vtkCellData> cells;
  for (int i = 0; i < from->GetPointData()->GetNumberOfArrays(); ++i)
    if (vtkDataArray* array = from->GetPointData()->GetArray(i))
      if (!array->GetName() || !to->GetPointData()->HasArray(array->GetName()))
        points->AddArray(array);
  for (int i = 0; i < from->GetCellData()->GetNumberOfArrays(); ++i)
    if (vtkDataArray* array = from->GetCellData()->GetArray(i))
      if (!array->GetName() || !to->GetCellData()->HasArray(array->GetName()))
        cells->AddArray(array);

  vtkNew<vtkPointData> new_points;
  new_points->InterpolateAllocate(points, change.mesh.VertexCount());
  vtkNew<vtkIdList> parents;
  parents->SetNumberOfIds(4);
  for (kerf::Index v = 0; v < change.mesh.VertexCount(); ++v) {
    double weights[4];
    for (int k = 0; k < 4; ++k) {
      parents->SetId(k, change.vertex_parents[v][k]);
      weights[k] = change.vertex_weights(v, k);
    }
    new_points->InterpolatePoint(points, v, parents, weights);
  }
  vtkNew<vtkCellData> new_cells;
  new_cells->CopyAllocate(cells, change.mesh.TetCount());
  for (kerf::Index t = 0; t < change.mesh.TetCount(); ++t)
    new_cells->CopyData(cells, change.parent_tet[t], t);
  for (int i = 0; i < new_points->GetNumberOfArrays(); ++i)
    to->GetPointData()->AddArray(new_points->GetArray(i));
  for (int i = 0; i < new_cells->GetNumberOfArrays(); ++i)
    to->GetCellData()->AddArray(new_cells->GetArray(i));
  for (int i = 0; i < from->GetFieldData()->GetNumberOfArrays(); ++i)
    to->GetFieldData()->AddArray(from->GetFieldData()->GetAbstractArray(i));
}

}  // namespace

vtkKerfCutTetraGrid::vtkKerfCutTetraGrid() { this->SetNumberOfInputPorts(2); }

int vtkKerfCutTetraGrid::FillInputPortInformation(int port, vtkInformation* info) {
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(),
            port == 0 ? "vtkUnstructuredGrid" : "vtkPolyData");
  return 1;
}

int vtkKerfCutTetraGrid::RequestData(vtkInformation*, vtkInformationVector** input,
                                     vtkInformationVector* output) {
  vtkUnstructuredGrid* grid = vtkUnstructuredGrid::GetData(input[0]);
  vtkPolyData* surface = vtkPolyData::GetData(input[1]);
  vtkUnstructuredGrid* cut = vtkUnstructuredGrid::GetData(output);
  this->Report = {};
  try {
    kerf::Points positions;
    const kerf::TetMesh mesh = kerf::TetMeshFromVtk(grid, "grid to cut", &positions);
    const kerf::SurfaceMesh s = kerf::SurfaceFromVtk(surface, "separation surface");
    kerf::CutOptions options;
    options.snap_fraction = this->SnapFraction;
    options.min_dihedral_deg = this->MinimumDihedralAngle;
    options.min_volume_share = this->MinimumVolumeShare;
    options.max_new_vertices = this->MaximumNewVertices;
    options.max_new_tets = this->MaximumNewTetrahedra;
    const kerf::TopologyChange change =
        kerf::TetCutter(options).Cut(mesh, {s.points, s.triangles}, &this->Report, &positions);
    cut->ShallowCopy(kerf::ToVtk(change.mesh, change.MapVertexField(positions)));
    CarryOver(change, grid, cut);
  } catch (const std::exception& error) {
    cut->Initialize();
    vtkErrorMacro(<< error.what());
    return 0;
  }
  return 1;
}

void vtkKerfCutTetraGrid::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SnapFraction: " << this->SnapFraction << "\n"
     << indent << "MinimumDihedralAngle: " << this->MinimumDihedralAngle << "\n"
     << indent << "MinimumVolumeShare: " << this->MinimumVolumeShare << "\n"
     << indent << "MaximumNewVertices: " << this->MaximumNewVertices << "\n"
     << indent << "MaximumNewTetrahedra: " << this->MaximumNewTetrahedra << "\n"
     << indent << "Cut: " << this->Report.done << "\n"
     << indent << "Partial: " << this->Report.partial << "\n"
     << indent << "Reason: " << this->Report.reason << "\n"
     << indent << "Components: " << this->Report.components << "\n";
}
