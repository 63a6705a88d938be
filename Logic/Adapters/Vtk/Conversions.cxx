#include "Adapters/Vtk/Conversions.h"

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkTriangleFilter.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <cstring>

#include "Core/Errors.h"

namespace kerf {
namespace {

vtkSmartPointer<vtkDoubleArray> ToArray(const Points& points) {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(points.rows());
  if (points.size() > 0)
    std::memcpy(array->GetPointer(0), points.data(), sizeof(double) * points.size());
  return array;
}

vtkSmartPointer<vtkPoints> ToPoints(const Points& points) {
  auto out = vtkSmartPointer<vtkPoints>::New();
  out->SetData(ToArray(points));
  return out;
}

Points FromPoints(vtkPointSet* data) {
  Points points(data->GetNumberOfPoints(), 3);
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) data->GetPoint(i, points.row(i).data());
  return points;
}

void AddRestPositions(const Points& rest, vtkDataSet* data) {
  const auto array = ToArray(rest);
  array->SetName(kRestPositionArray);
  data->GetPointData()->AddArray(array);
}

template <typename Cells>
vtkSmartPointer<vtkCellArray> ToCells(const Cells& cells) {
  auto out = vtkSmartPointer<vtkCellArray>::New();
  out->AllocateExact(cells.rows(), cells.size());
  for (Index c = 0; c < cells.rows(); ++c) {
    out->InsertNextCell(static_cast<int>(cells.cols()));
    for (int k = 0; k < cells.cols(); ++k) out->InsertCellPoint(cells(c, k));
  }
  return out;
}

template <typename T>
std::shared_ptr<const std::vector<T>> VoxelsFromVtk(vtkImageData* image, const std::string& file) {
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  if (!scalars || scalars->GetNumberOfComponents() != 1)
    throw InputError(file, "scalars", "one value per voxel is needed");
  auto voxels = std::make_shared<std::vector<T>>(scalars->GetNumberOfTuples());
  for (std::size_t i = 0; i < voxels->size(); ++i)
    (*voxels)[i] = static_cast<T>(scalars->GetComponent(static_cast<vtkIdType>(i), 0));
  return voxels;
}

template <typename T>
vtkSmartPointer<vtkImageData> ImageOf(const GridGeometry& grid, const std::vector<T>& voxels,
                                      int type) {
  auto image = vtkSmartPointer<vtkImageData>::New();
  SetGrid(grid, image);
  image->AllocateScalars(type, 1);
  std::memcpy(image->GetScalarPointer(), voxels.data(), sizeof(T) * voxels.size());
  return image;
}

}  // namespace

vtkSmartPointer<vtkPolyData> ToVtk(const SurfaceMesh& surface, const Points* rest_position) {
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(ToPoints(surface.points));
  data->SetPolys(ToCells(surface.triangles));
  if (rest_position) AddRestPositions(*rest_position, data);
  return data;
}

SurfaceMesh SurfaceFromVtk(vtkPolyData* data, const std::string& file) {
  vtkNew<vtkTriangleFilter> triangulate;
  triangulate->SetInputData(data);
  triangulate->PassLinesOff();
  triangulate->PassVertsOff();
  // Indices are checked first: the filter would read beyond the points.
  for (vtkCellArray* cells : {data->GetPolys(), data->GetStrips()}) {
    const auto it = vtk::TakeSmartPointer(cells->NewIterator());
    for (it->GoToFirstCell(); !it->IsDoneWithTraversal(); it->GoToNextCell()) {
      vtkIdType count;
      const vtkIdType* corner;
      it->GetCurrentCell(count, corner);
      for (vtkIdType k = 0; k < count; ++k)
        if (corner[k] < 0 || corner[k] >= data->GetNumberOfPoints())
          throw InputError(file, "triangle " + std::to_string(it->GetCurrentCellId()),
                           "refers to point " + std::to_string(corner[k]) + " of " +
                               std::to_string(data->GetNumberOfPoints()));
    }
  }
  triangulate->Update();
  vtkPolyData* triangles = triangulate->GetOutput();
  SurfaceMesh surface;
  if (data->GetNumberOfPoints() > 0) surface.points = FromPoints(data);
  surface.triangles.resize(triangles->GetNumberOfPolys(), 3);
  const auto it = vtk::TakeSmartPointer(triangles->GetPolys()->NewIterator());
  for (it->GoToFirstCell(); !it->IsDoneWithTraversal(); it->GoToNextCell()) {
    vtkIdType count;
    const vtkIdType* corner;
    it->GetCurrentCell(count, corner);
    for (int k = 0; k < 3; ++k)
      surface.triangles(it->GetCurrentCellId(), k) = static_cast<Index>(corner[k]);
  }
  surface.Validate(file);
  return surface;
}

vtkSmartPointer<vtkUnstructuredGrid> ToVtk(const TetMesh& mesh, const Points& positions) {
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(ToPoints(positions));
  grid->SetCells(VTK_TETRA, ToCells(mesh.tets));
  AddRestPositions(mesh.rest, grid);
  vtkNew<vtkUnsignedCharArray> region;
  region->SetName(kRegionArray);
  region->SetNumberOfTuples(mesh.TetCount());
  for (Index t = 0; t < mesh.TetCount(); ++t) region->SetValue(t, mesh.region[t]);
  grid->GetCellData()->AddArray(region);
  return grid;
}

vtkSmartPointer<vtkUnstructuredGrid> ToVtk(const TetMesh& mesh) { return ToVtk(mesh, mesh.rest); }

TetMesh TetMeshFromVtk(vtkUnstructuredGrid* grid, const std::string& file, Points* positions) {
  TetMesh mesh;
  const vtkIdType count = grid->GetNumberOfCells();
  const Points current = grid->GetNumberOfPoints() > 0 ? FromPoints(grid) : Points(0, 3);
  if (!RestPositionsFromVtk(grid, &mesh.rest)) mesh.rest = current;
  mesh.tets.resize(count, 4);
  vtkNew<vtkIdList> corners;
  for (vtkIdType c = 0; c < count; ++c) {
    if (grid->GetCellType(c) != VTK_TETRA)
      throw InputError(file, "cell " + std::to_string(c), "is not a tetrahedron");
    grid->GetCellPoints(c, corners);
    if (corners->GetNumberOfIds() != 4)
      throw InputError(file, "cell " + std::to_string(c), "has not four corners");
    for (int k = 0; k < 4; ++k) mesh.tets(c, k) = static_cast<Index>(corners->GetId(k));
  }
  vtkDataArray* region = grid->GetCellData()->GetArray(kRegionArray);
  mesh.region.assign(count, static_cast<std::uint8_t>(Label::Organ));
  if (region)
    for (vtkIdType c = 0; c < count; ++c)
      mesh.region[c] = static_cast<std::uint8_t>(region->GetComponent(c, 0));
  mesh.Validate(file);
  if (positions) *positions = current;
  return mesh;
}

bool RestPositionsFromVtk(vtkDataSet* data, Points* rest) {
  vtkDataArray* array = data->GetPointData()->GetArray(kRestPositionArray);
  if (!array || array->GetNumberOfComponents() != 3 ||
      array->GetNumberOfTuples() != data->GetNumberOfPoints())
    return false;
  rest->resize(array->GetNumberOfTuples(), 3);
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
    array->GetTuple(i, rest->row(i).data());
  return true;
}

GridGeometry GridFromVtk(vtkImageData* image) {
  GridGeometry grid;
  image->GetDimensions(grid.size.data());
  image->GetSpacing(grid.spacing_mm.data());
  const vtkMatrix3x3* direction = image->GetDirectionMatrix();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) grid.direction(r, c) = direction->GetElement(r, c);
  // VTK's origin belongs to index (0,0,0); ours to the first voxel of the extent.
  const int* extent = image->GetExtent();
  Vec3 origin;
  image->GetOrigin(origin.data());
  grid.origin_mm =
      origin + grid.direction * grid.spacing_mm.cwiseProduct(Vec3(extent[0], extent[2], extent[4]));
  return grid;
}

void SetGrid(const GridGeometry& grid, vtkImageData* image) {
  image->SetDimensions(grid.size.data());
  image->SetSpacing(grid.spacing_mm.data());
  image->SetOrigin(grid.origin_mm.data());
  const Mat3& d = grid.direction;
  image->SetDirectionMatrix(d(0, 0), d(0, 1), d(0, 2), d(1, 0), d(1, 1), d(1, 2), d(2, 0), d(2, 1),
                            d(2, 2));
}

vtkSmartPointer<vtkImageData> ToVtk(const LabelMap& labels) {
  return ImageOf(labels.grid, *labels.voxels, VTK_UNSIGNED_CHAR);
}

vtkSmartPointer<vtkImageData> ToVtk(const Volume& volume) {
  return ImageOf(volume.grid, *volume.voxels, VTK_SHORT);
}

LabelMap LabelMapFromVtk(vtkImageData* image, const std::string& source) {
  LabelMap labels;
  labels.grid = GridFromVtk(image);
  labels.voxels = VoxelsFromVtk<std::uint8_t>(image, source);
  labels.source = source;
  return labels;
}

Volume VolumeFromVtk(vtkImageData* image, const std::string& source) {
  Volume volume;
  volume.grid = GridFromVtk(image);
  volume.voxels = VoxelsFromVtk<std::int16_t>(image, source);
  volume.source = source;
  return volume;
}

}  // namespace kerf
