#pragma once

#include <vtkSmartPointer.h>

#include <string>

#include "Core/SurfaceMesh.h"
#include "Core/TetMesh.h"
#include "Core/Volume.h"

class vtkDataSet;
class vtkImageData;
class vtkPolyData;
class vtkUnstructuredGrid;

/// Core values ↔ VTK data sets, LPS mm on both sides, double coordinates. Nothing is shared: both
/// sides own their data.
namespace kerf {

/// Names of the arrays that carry what VTK has no place for (DESIGN §3, results folder).
inline constexpr const char* kRestPositionArray = "rest_position_mm";  ///< point data, 3 components
inline constexpr const char* kRegionArray = "region";                  ///< cell data, Label values
inline constexpr const char* kSpaceArray = "SPACE";                    ///< field data, string

/// @param rest_position N×3, becomes the point array rest_position_mm; may be null
vtkSmartPointer<vtkPolyData> ToVtk(const SurfaceMesh& surface,
                                   const Points* rest_position = nullptr);
/// Polygons and strips are triangulated; lines and vertices are left out.
/// @param file for messages. @throws InputError on NaN, bad indices
SurfaceMesh SurfaceFromVtk(vtkPolyData* data, const std::string& file);

/// A tetra mesh at rest.
vtkSmartPointer<vtkUnstructuredGrid> ToVtk(const TetMesh& mesh);
/// As deformed: points are `positions`, rest_position_mm holds the rest.
vtkSmartPointer<vtkUnstructuredGrid> ToVtk(const TetMesh& mesh, const Points& positions);
/// Rest = rest_position_mm where the grid has it, otherwise its points; region = 1 where it has
/// none.
/// @param positions current points, may be null. @throws InputError on cells other than tetrahedra,
/// inverted at rest
TetMesh TetMeshFromVtk(vtkUnstructuredGrid* grid, const std::string& file,
                       Points* positions = nullptr);

/// The point array rest_position_mm. @return false where there is none (or it has not three
/// components)
bool RestPositionsFromVtk(vtkDataSet* data, Points* rest);

/// Labels (unsigned char) and CT (short) with origin, spacing and direction matrix.
vtkSmartPointer<vtkImageData> ToVtk(const LabelMap& labels);
vtkSmartPointer<vtkImageData> ToVtk(const Volume& volume);
/// @throws InputError where there are no scalars of one component
LabelMap LabelMapFromVtk(vtkImageData* image, const std::string& source);
Volume VolumeFromVtk(vtkImageData* image, const std::string& source);
GridGeometry GridFromVtk(vtkImageData* image);
void SetGrid(const GridGeometry& grid, vtkImageData* image);

}  // namespace kerf
