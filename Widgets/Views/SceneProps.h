#pragma once

#include <vtkProp.h>
#include <vtkSmartPointer.h>

#include <QColor>
#include <string>
#include <vector>

#include "Core/SurfaceMesh.h"

class vtkLookupTable;

/// What the 3-D view shows, as VTK draws it. Positions in LPS mm; opacity 0..1.
namespace kerf_scene {

/// Red where it is near, blue where it is far, through colours of rising brightness.
void FillNearToFar(vtkLookupTable* table);

vtkSmartPointer<vtkProp> SurfaceProp(const kerf::SurfaceMesh& surface, const QColor& color,
                                     double opacity);
/// @param values by point or by triangle; @param table colours, with its range
vtkSmartPointer<vtkProp> ColoredSurfaceProp(const kerf::SurfaceMesh& surface,
                                            const std::vector<double>& values,
                                            vtkLookupTable* table, double opacity);
/// Drawn in front of the surface that it lies on.
vtkSmartPointer<vtkProp> LineProp(const kerf::Points& points, const QColor& color, double width_px);
vtkSmartPointer<vtkProp> BallsProp(const kerf::Points& points, const QColor& color,
                                   double radius_mm);
vtkSmartPointer<vtkProp> NameProp(const std::string& name, const kerf::Vec3& at_mm);
/// Where the values of the surface's points equal `value`. @param values by point
vtkSmartPointer<vtkProp> IsolineProp(const kerf::SurfaceMesh& surface,
                                     const std::vector<double>& values, double value,
                                     const QColor& color);

}  // namespace kerf_scene
