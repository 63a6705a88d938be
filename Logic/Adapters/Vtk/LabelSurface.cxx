#include "Adapters/Vtk/LabelSurface.h"

#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>

#include "Adapters/Vtk/Conversions.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

/// The field on a grid whose voxels are `factor` times as wide; the same extent.
LabelField Resampled(const LabelField& field, double factor) {
  LabelField out = field;
  for (int d = 0; d < 3; ++d) {
    out.grid.size[d] =
        std::max(4, static_cast<int>(std::ceil((field.grid.size[d] - 1) / factor)) + 1);
    out.grid.spacing_mm[d] =
        field.grid.spacing_mm[d] * (field.grid.size[d] - 1) / (out.grid.size[d] - 1);
  }
  out.values.resize(out.grid.VoxelCount());
  for (int k = 0; k < out.grid.size[2]; ++k)
    for (int j = 0; j < out.grid.size[1]; ++j)
      for (int i = 0; i < out.grid.size[0]; ++i)
        out.values[out.grid.Offset(i, j, k)] =
            static_cast<float>(field.At(out.grid.WorldFromIndex(Vec3(i, j, k))));
  return out;
}

SurfaceMesh Contour(const LabelField& field, double level, const std::string& source) {
  // In index space: VTK's filters differ in what they make of a direction matrix.
  vtkNew<vtkImageData> image;
  image->SetDimensions(field.grid.size.data());
  vtkNew<vtkFloatArray> values;
  values->SetNumberOfTuples(static_cast<vtkIdType>(field.values.size()));
  std::copy(field.values.begin(), field.values.end(), values->GetPointer(0));
  image->GetPointData()->SetScalars(values);
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(image);
  contour->SetValue(0, level);
  contour->ComputeNormalsOff();
  contour->ComputeScalarsOff();
  contour->Update();
  SurfaceMesh surface = SurfaceFromVtk(contour->GetOutput(), source);
  for (Index i = 0; i < surface.points.rows(); ++i)
    surface.points.row(i) =
        field.grid.WorldFromIndex(surface.points.row(i).transpose()).transpose();
  if (surface.SignedVolume() < 0.0) surface.triangles.col(1).swap(surface.triangles.col(2));
  return surface;
}

}  // namespace

SurfaceMesh SurfaceOfField(const LabelField& field, const std::string& source, Index max_points) {
  if (field.Empty()) throw InputError(source, "labels", "no voxel to make a surface of");
  // A grid point that lies on the level exactly gives triangles without an area: step aside.
  SurfaceMesh surface;
  for (const double aside : {0.0, 1.7e-4, -2.3e-4, 5.9e-4}) {
    surface = Contour(field, field.level + aside, source);
    for (double factor = 1.0; surface.points.rows() > max_points && factor < 20.0;) {
      factor *= 1.05 * std::sqrt(static_cast<double>(surface.points.rows()) / max_points);
      surface = Contour(Resampled(field, factor), field.level + aside, source);
    }
    if (surface.IsClosedManifold()) return surface;
  }
  throw InputError(source, "labels", "their boundary gives no closed surface");
}

}  // namespace kerf
