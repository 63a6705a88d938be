#pragma once

#include <vtkPolyDataAlgorithm.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <vector>

#include "Core/Camera.h"

class vtkCellArray;

/// Surface in patient LPS → the same surface as a distorted lens sees it, ready for an ideal
/// pinhole.
///
/// Output points are in the camera frame, bent by kerf::LensDistortion (depth is kept, so hidden
/// surfaces stay right); render them with kerf::SetLensCamera of GetIdealPinhole(). Point scalars
/// `surface_buffer` (3 unsigned chars): how squarely the surface faces the camera (255 = fully),
/// its class, 0. Triangles whose cell array `cut_face` is non-zero get the class CutFace and
/// vertices of their own, so that neither class nor normal is mixed along the edge of a cut.
/// Triangles that reach behind the lens are left out. The connectivity is rebuilt when the input's
/// cells change; a moving surface costs its points alone. Put vtkKerfEmbeddedWarp before it for
/// structures embedded in a moving grid.
class vtkKerfLensWarp : public vtkPolyDataAlgorithm {
 public:
  static vtkKerfLensWarp* New();
  vtkTypeMacro(vtkKerfLensWarp, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void SetLens(const kerf::CameraModel& lens);
  const kerf::CameraModel& GetLens() const { return Lens; }
  /// Camera without distortion in whose frame the output lies.
  kerf::CameraModel GetIdealPinhole() const;

  /// Class of triangles that are no cut face; 1 by default.
  vtkSetMacro(SurfaceClass, unsigned char);
  vtkGetMacro(SurfaceClass, unsigned char);
  /// Class of cut faces; 2 by default.
  vtkSetMacro(CutFaceClass, unsigned char);
  vtkGetMacro(CutFaceClass, unsigned char);

  /// Depths of the points in front of the lens in the last update, mm; nearest > farthest when
  /// there are none.
  vtkGetVector2Macro(DepthRange, double);

  /// Image region of the points in the last update, px: x from, to, y from, to. Boundless where a
  /// point lies behind the lens; from > to when there are none.
  vtkGetVector4Macro(ScreenRange, double);

  /// Whether nobody can see the back of a triangle of the last update: the surface is closed,
  /// turned outwards, and all of it lies before the lens.
  vtkGetMacro(Solid, bool);

  /// Nearest depth that a lens has an image of, mm.
  static constexpr double NearestDepth = 1.0;

 protected:
  vtkKerfLensWarp() = default;
  ~vtkKerfLensWarp() override = default;
  int RequestData(vtkInformation*, vtkInformationVector** input,
                  vtkInformationVector* output) override;

 private:
  vtkKerfLensWarp(const vtkKerfLensWarp&) = delete;
  void operator=(const vtkKerfLensWarp&) = delete;
  /// Splits vertices between classes. @return false when nothing changed since the last update
  bool UpdateTopology(vtkPolyData* input);
  void BuildCells(const kerf::Points& eye);

  kerf::CameraModel Lens;
  unsigned char SurfaceClass = 1;
  unsigned char CutFaceClass = 2;
  double DepthRange[2] = {1e9, 0};
  double ScreenRange[4] = {1e9, -1e9, 1e9, -1e9};

  kerf::Triangles Corners;           // in output vertices
  std::vector<vtkIdType> Source;     // input point of each output vertex
  std::vector<unsigned char> IsCut;  // of each output vertex
  vtkSmartPointer<vtkCellArray> Cells;
  bool Incomplete = false;  // some triangle is left out of Cells
  bool Closed = false;      // every edge is passed as often in one direction as in the other
  bool Solid = false;
  vtkIdType InputPoints = -1;
  vtkSmartPointer<vtkCellArray> InputCells;
  vtkMTimeType InputCellsTime = 0, InputFlagsTime = 0;
};
