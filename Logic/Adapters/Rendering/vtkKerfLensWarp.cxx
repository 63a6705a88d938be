#include "Adapters/Rendering/vtkKerfLensWarp.h"

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "Adapters/Rendering/LensCamera.h"

vtkStandardNewMacro(vtkKerfLensWarp);

namespace {

/// @param corners as the surface has them, before vertices are split
bool IsClosed(const kerf::Triangles& corners, const std::vector<vtkIdType>& source) {
  std::vector<std::array<vtkIdType, 2>> forth, back;
  for (kerf::Index t = 0; t < corners.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const vtkIdType a = source[corners(t, k)], b = source[corners(t, (k + 1) % 3)];
      (a < b ? forth : back).push_back({std::min(a, b), std::max(a, b)});
    }
  std::sort(forth.begin(), forth.end());
  std::sort(back.begin(), back.end());
  return forth == back;
}

}  // namespace

void vtkKerfLensWarp::PrintSelf(ostream& os, vtkIndent indent) {
  Superclass::PrintSelf(os, indent);
  os << indent << "Lens: " << Lens.width << "x" << Lens.height << " f " << Lens.fx << " " << Lens.fy
     << "\n";
  os << indent << "SurfaceClass: " << int(SurfaceClass) << "\n";
  os << indent << "CutFaceClass: " << int(CutFaceClass) << "\n";
  os << indent << "DepthRange: " << DepthRange[0] << " " << DepthRange[1] << "\n";
  os << indent << "ScreenRange: " << ScreenRange[0] << " " << ScreenRange[1] << " "
     << ScreenRange[2] << " " << ScreenRange[3] << "\n";
  os << indent << "Solid: " << Solid << "\n";
}

void vtkKerfLensWarp::SetLens(const kerf::CameraModel& lens) {
  Lens = lens;
  Modified();
}

kerf::CameraModel vtkKerfLensWarp::GetIdealPinhole() const {
  return kerf::LensDistortion(Lens).IdealPinhole();
}

bool vtkKerfLensWarp::UpdateTopology(vtkPolyData* input) {
  vtkCellArray* cells = input->GetPolys();
  vtkDataArray* cut = input->GetCellData()->GetArray("cut_face");
  const vtkMTimeType flags_time = cut ? cut->GetMTime() : 0;
  if (InputCells == cells && InputCellsTime == cells->GetMTime() && InputFlagsTime == flags_time &&
      InputPoints == input->GetNumberOfPoints())
    return false;
  InputCells = cells;
  InputCellsTime = cells->GetMTime();
  InputFlagsTime = flags_time;
  InputPoints = input->GetNumberOfPoints();
  Source.clear();
  IsCut.clear();
  Corners.resize(static_cast<kerf::Index>(cells->GetNumberOfCells()), 3);
  std::vector<kerf::Index> copy[2];
  for (auto& c : copy) c.assign(static_cast<std::size_t>(InputPoints), -1);
  kerf::Index triangles = 0;
  auto it = vtk::TakeSmartPointer(cells->NewIterator());
  for (it->GoToFirstCell(); !it->IsDoneWithTraversal(); it->GoToNextCell()) {
    vtkIdType size = 0;
    const vtkIdType* ids = nullptr;
    it->GetCurrentCell(size, ids);
    if (size != 3) continue;  // surfaces of Kerf are triangles
    const bool face = cut && cut->GetTuple1(it->GetCurrentCellId()) != 0;
    for (int k = 0; k < 3; ++k) {
      kerf::Index& id = copy[face][static_cast<std::size_t>(ids[k])];
      if (id < 0) {
        id = static_cast<kerf::Index>(Source.size());
        Source.push_back(ids[k]);
        IsCut.push_back(face);
      }
      Corners(triangles, k) = id;
    }
    ++triangles;
  }
  Corners.conservativeResize(triangles, 3);
  Closed = triangles == cells->GetNumberOfCells() && IsClosed(Corners, Source);
  return true;
}

void vtkKerfLensWarp::BuildCells(const kerf::Points& eye) {
  vtkNew<vtkIdTypeArray> connectivity, offsets;
  Incomplete = false;
  for (kerf::Index t = 0; t < Corners.rows(); ++t) {
    const auto c = Corners.row(t);
    if (std::min({eye(c[0], 2), eye(c[1], 2), eye(c[2], 2)}) < NearestDepth) {
      Incomplete = true;
      continue;
    }
    offsets->InsertNextValue(connectivity->GetNumberOfValues());
    for (int k = 0; k < 3; ++k) connectivity->InsertNextValue(c[k]);
  }
  offsets->InsertNextValue(connectivity->GetNumberOfValues());
  Cells = vtkSmartPointer<vtkCellArray>::New();
  Cells->SetData(offsets, connectivity);
}

int vtkKerfLensWarp::RequestData(vtkInformation*, vtkInformationVector** input_vector,
                                 vtkInformationVector* output_vector) {
  vtkPolyData* input = vtkPolyData::GetData(input_vector[0]);
  vtkPolyData* output = vtkPolyData::GetData(output_vector);
  DepthRange[0] = 1e9;
  DepthRange[1] = 0;
  Solid = false;
  std::copy_n(std::begin({1e9, -1e9, 1e9, -1e9}), 4, ScreenRange);
  if (!input || !input->GetPoints()) return 1;
  const bool fresh = UpdateTopology(input);

  const kerf::LensDistortion distortion(Lens);
  const auto n = static_cast<kerf::Index>(Source.size());
  kerf::Points eye(n, 3), normal = kerf::Points::Zero(n, 3);
  for (kerf::Index i = 0; i < n; ++i) {
    kerf::Vec3 world;
    input->GetPoint(Source[static_cast<std::size_t>(i)], world.data());
    eye.row(i) = (Lens.camera_from_world * world).transpose();
  }
  double volume = 0.0;  // six times that of the solid
  for (kerf::Index t = 0; t < Corners.rows(); ++t) {
    const auto c = Corners.row(t);
    const kerf::Vec3 a = eye.row(c[0]), b = eye.row(c[1]), d = eye.row(c[2]);
    const kerf::Vec3 area = (b - a).cross(d - a);
    volume += a.dot(area);
    for (int k = 0; k < 3; ++k) normal.row(c[k]) += area.transpose();
  }
  vtkNew<vtkFloatArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetNumberOfTuples(n);
  vtkNew<vtkUnsignedCharArray> buffer;
  buffer->SetName("surface_buffer");
  buffer->SetNumberOfComponents(3);
  buffer->SetNumberOfTuples(n);
  float* xyz = coordinates->GetPointer(0);
  unsigned char* rgb = buffer->GetPointer(0);
  bool behind = false;
  for (kerf::Index i = 0; i < n; ++i) {
    const kerf::Vec3 p = eye.row(i), bent = distortion.Apply(p);
    for (int k = 0; k < 3; ++k) xyz[3 * i + k] = static_cast<float>(bent[k]);
    const double scale = normal.row(i).norm() * p.norm();
    const double facing = scale > 0 ? std::abs(normal.row(i).dot(p)) / scale : 0.0;
    rgb[3 * i] = static_cast<unsigned char>(std::lround(255.0 * std::min(1.0, facing)));
    rgb[3 * i + 1] = IsCut[static_cast<std::size_t>(i)] ? CutFaceClass : SurfaceClass;
    rgb[3 * i + 2] = 0;
    if (p.z() < NearestDepth) {
      behind = true;
    } else {
      DepthRange[0] = std::min(DepthRange[0], p.z());
      DepthRange[1] = std::max(DepthRange[1], p.z());
      const double at[2] = {Lens.fx * bent.x() / bent.z() + Lens.cx,
                            Lens.fy * bent.y() / bent.z() + Lens.cy};
      for (int k = 0; k < 2; ++k) {
        ScreenRange[2 * k] = std::min(ScreenRange[2 * k], at[k]);
        ScreenRange[2 * k + 1] = std::max(ScreenRange[2 * k + 1], at[k]);
      }
    }
  }
  Solid = Closed && !behind && volume > 0.0;
  if (behind) std::copy_n(std::begin({-1e9, 1e9, -1e9, 1e9}), 4, ScreenRange);
  if (fresh || behind || Incomplete) BuildCells(eye);
  vtkNew<vtkPoints> points;
  points->SetData(coordinates);
  output->SetPoints(points);
  output->SetPolys(Cells);
  output->GetPointData()->SetScalars(buffer);
  return 1;
}
