#include "Adapters/Vtk/vtkKerfEmbeddedWarp.h"

#include <vtkDoubleArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include <cstring>

#include "Adapters/Vtk/Conversions.h"

vtkStandardNewMacro(vtkKerfEmbeddedWarp);

namespace {

vtkSmartPointer<vtkDoubleArray> CopyOf(const kerf::Points& points) {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(points.rows());
  if (points.size() > 0)
    std::memcpy(array->GetPointer(0), points.data(), sizeof(double) * points.size());
  return array;
}

bool Same(const kerf::Points& a, const kerf::Points& b) {
  return a.rows() == b.rows() && (a.array() == b.array()).all();
}

}  // namespace

vtkKerfEmbeddedWarp::vtkKerfEmbeddedWarp() { this->SetNumberOfInputPorts(2); }

int vtkKerfEmbeddedWarp::FillInputPortInformation(int port, vtkInformation* info) {
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(),
            port == 0 ? "vtkPolyData" : "vtkUnstructuredGrid");
  return 1;
}

int vtkKerfEmbeddedWarp::RequestData(vtkInformation*, vtkInformationVector** input,
                                     vtkInformationVector* output) {
  vtkPolyData* surface = vtkPolyData::GetData(input[0]);
  vtkUnstructuredGrid* grid = vtkUnstructuredGrid::GetData(input[1]);
  vtkPolyData* warped = vtkPolyData::GetData(output);
  try {
    kerf::Points positions, rest(surface->GetNumberOfPoints(), 3);
    const kerf::TetMesh mesh = kerf::TetMeshFromVtk(grid, "deformed grid", &positions);
    for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i)
      surface->GetPoint(i, rest.row(i).data());
    // Compared by value: sources that rebuild their output each frame must not cost a new search.
    const bool same_tets =
        mesh.tets.rows() == this->Tets.rows() && (mesh.tets.array() == this->Tets.array()).all();
    if (!same_tets || !Same(rest, this->SurfaceRest) || !Same(mesh.rest, this->GridRest)) {
      this->Embedding = kerf::EmbedPoints(mesh, rest, &this->Report);
      this->SurfaceRest = rest;
      this->GridRest = mesh.rest;
      this->Tets = mesh.tets;
      ++this->EmbeddingCount;
    }
    warped->ShallowCopy(surface);
    vtkNew<vtkPoints> points;
    points->SetData(CopyOf(this->Embedding.Positions(positions, mesh.tets)));
    warped->SetPoints(points);
    const auto rest_array = CopyOf(rest);
    rest_array->SetName(kerf::kRestPositionArray);
    warped->GetPointData()->AddArray(rest_array);
  } catch (const std::exception& error) {
    warped->Initialize();
    vtkErrorMacro(<< error.what());
    return 0;
  }
  return 1;
}

void vtkKerfEmbeddedWarp::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "PointsOutside: " << this->Report.outside << "\n"
     << indent << "EmbeddingCount: " << this->EmbeddingCount << "\n";
}
