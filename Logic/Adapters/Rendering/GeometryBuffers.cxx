#include "Adapters/Rendering/GeometryBuffers.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>

#include "Adapters/Rendering/LensCamera.h"

// Registers VTK's OpenGL and FreeType factories for whoever links this library, however it was
// linked.
#include <vtkAutoInit.h>
VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)

namespace kerf {
namespace {

constexpr double kNearest_mm = 1.0;

// One surface in the scene: keeps its connectivity from frame to frame and only moves the points
// while it is the same.
class BufferActor {
 public:
  BufferActor() {
    colors_->SetNumberOfComponents(3);
    poly_->SetPoints(points_);
    points_->SetDataTypeToFloat();
    poly_->GetPointData()->SetScalars(colors_);
    mapper_->SetInputData(poly_);
    mapper_->SetColorModeToDirectScalars();
    mapper_->SetScalarModeToUsePointData();
    actor_->SetMapper(mapper_);
    actor_->GetProperty()->LightingOff();
    actor_->GetProperty()->SetInterpolationToFlat();
  }
  vtkActor* Actor() { return actor_; }

  // Extends [near, far] by the depths of what can be seen.
  void Update(const GeometryBuffers::Part& part, const CameraModel& camera,
              const LensDistortion& lens, double* near_mm, double* far_mm) {
    UpdateTopology(part);
    const Index n = static_cast<Index>(source_.size());
    Points eye(n, 3), normal = Points::Zero(n, 3);
    for (Index i = 0; i < n; ++i)
      eye.row(i) = (camera.camera_from_world * Vec3(part.mesh->points.row(source_[i]).transpose()))
                       .transpose();
    for (Index t = 0; t < corners_.rows(); ++t) {
      const auto c = corners_.row(t);
      const Vec3 a = eye.row(c[0]), b = eye.row(c[1]), d = eye.row(c[2]);
      const Vec3 area = (b - a).cross(d - a);
      for (int k = 0; k < 3; ++k) normal.row(c[k]) += area.transpose();
    }
    points_->SetNumberOfPoints(n);
    colors_->SetNumberOfTuples(n);
    float* xyz = vtkFloatArray::SafeDownCast(points_->GetData())->GetPointer(0);
    unsigned char* rgb = colors_->GetPointer(0);
    bool behind = false;
    for (Index i = 0; i < n; ++i) {
      const Vec3 p = eye.row(i);
      const Vec3 bent = lens.Apply(p);
      for (int k = 0; k < 3; ++k) xyz[3 * i + k] = static_cast<float>(bent[k]);
      const double scale = normal.row(i).norm() * p.norm();
      const double facing = scale > 0 ? std::abs(normal.row(i).dot(p)) / scale : 0.0;
      rgb[3 * i] = static_cast<unsigned char>(std::lround(255.0 * std::min(1.0, facing)));
      rgb[3 * i + 1] = surface_[i];
      rgb[3 * i + 2] = 0;
      if (p.z() < kNearest_mm) {
        behind = true;
      } else {
        *near_mm = std::min(*near_mm, p.z());
        *far_mm = std::max(*far_mm, p.z());
      }
    }
    if (behind || dropped_) UpdateCells(eye);
    points_->Modified();
    colors_->Modified();
    poly_->Modified();
  }

 private:
  void UpdateTopology(const GeometryBuffers::Part& part) {
    const Triangles& triangles = part.mesh->triangles;
    const std::vector<std::uint8_t> cut =
        part.cut_face ? *part.cut_face : std::vector<std::uint8_t>();
    const Index points = static_cast<Index>(part.mesh->points.rows());
    if (points == mesh_points_ && cut == cut_ && kind_ == part.surface &&
        triangles.rows() == triangles_.rows() && triangles == triangles_)
      return;
    triangles_ = triangles;
    cut_ = cut;
    kind_ = part.surface;
    mesh_points_ = points;
    // A vertex on the edge of a cut gets one copy for each side, so that neither class nor normal
    // is mixed there.
    std::vector<Index> copy[2];
    source_.clear();
    surface_.clear();
    corners_.resize(triangles.rows(), 3);
    copy[0].assign(points, -1);
    copy[1].assign(points, -1);
    for (Index t = 0; t < triangles.rows(); ++t) {
      const bool face = !cut.empty() && cut[t] != 0;
      for (int k = 0; k < 3; ++k) {
        Index& id = copy[face][triangles(t, k)];
        if (id < 0) {
          id = static_cast<Index>(source_.size());
          source_.push_back(triangles(t, k));
          surface_.push_back(face ? GeometryBuffers::CutFace : part.surface);
        }
        corners_(t, k) = id;
      }
    }
    dropped_ = true;  // cells must be rebuilt
  }

  // Triangles that reach behind the camera are left out: a lens has no image of them.
  void UpdateCells(const Points& eye) {
    vtkNew<vtkIdTypeArray> connectivity, offsets;
    dropped_ = false;
    for (Index t = 0; t < corners_.rows(); ++t) {
      const auto c = corners_.row(t);
      if (eye(c[0], 2) < kNearest_mm || eye(c[1], 2) < kNearest_mm || eye(c[2], 2) < kNearest_mm) {
        dropped_ = true;
        continue;
      }
      offsets->InsertNextValue(connectivity->GetNumberOfValues());
      for (int k = 0; k < 3; ++k) connectivity->InsertNextValue(c[k]);
    }
    offsets->InsertNextValue(connectivity->GetNumberOfValues());
    vtkNew<vtkCellArray> cells;
    cells->SetData(offsets, connectivity);
    poly_->SetPolys(cells);
  }

  vtkNew<vtkPoints> points_;
  vtkNew<vtkUnsignedCharArray> colors_;
  vtkNew<vtkPolyData> poly_;
  vtkNew<vtkPolyDataMapper> mapper_;
  vtkNew<vtkActor> actor_;
  Triangles triangles_, corners_;
  std::vector<std::uint8_t> cut_;
  std::vector<Index> source_;          // mesh point of each drawn vertex
  std::vector<std::uint8_t> surface_;  // class of each drawn vertex
  GeometryBuffers::Surface kind_ = GeometryBuffers::Nothing;
  Index mesh_points_ = -1;
  bool dropped_ = false;
};

void Prepare(GeometryBuffer* buffer, int width, int height) {
  buffer->width = width;
  buffer->height = height;
  const std::size_t n = std::size_t(width) * height;
  buffer->surface.resize(n);
  buffer->facing.resize(n);
  buffer->depth_mm.resize(n);
}

}  // namespace

struct GeometryBuffers::Implementation {
  explicit Implementation(const CameraModel& c) : camera(c), lens(c) {
    window->SetOffScreenRendering(1);
    window->SetMultiSamples(0);
    window->SwapBuffersOff();  // nobody looks at the window: only its buffers are read
    window->SetSize(2 * c.width, c.height);
    for (int side = 0; side < 2; ++side) {
      renderer[side]->SetViewport(0.5 * side, 0, 0.5 * side + 0.5, 1);
      renderer[side]->SetBackground(0, 0, 0);
      renderer[side]->SetActiveCamera(vtk_camera);
      window->AddRenderer(renderer[side]);
      Prepare(&buffer[side], c.width, c.height);
    }
  }

  void Update(int side, const std::vector<Part>& parts, double* near_mm, double* far_mm) {
    while (actors[side].size() < parts.size()) {
      actors[side].push_back(std::make_unique<BufferActor>());
      renderer[side]->AddActor(actors[side].back()->Actor());
    }
    for (std::size_t i = 0; i < actors[side].size(); ++i) {
      const bool shown = i < parts.size() && parts[i].mesh && !parts[i].mesh->Empty();
      actors[side][i]->Actor()->SetVisibility(shown);
      if (shown) actors[side][i]->Update(parts[i], camera, lens, near_mm, far_mm);
    }
  }

  void Read(double near_mm, double far_mm) {
    const int w = camera.width, h = camera.height;
    window->GetPixelData(0, 0, 2 * w - 1, h - 1, 0, pixels);
    window->GetZbufferData(0, 0, 2 * w - 1, h - 1, depth);
    const unsigned char* rgb = pixels->GetPointer(0);
    const float* z = depth->GetPointer(0);
    const float nf = static_cast<float>(near_mm * far_mm), f = static_cast<float>(far_mm),
                range = static_cast<float>(far_mm - near_mm);
    for (int side = 0; side < 2; ++side)
      for (int y = 0; y < h; ++y) {
        const std::size_t from = std::size_t(h - 1 - y) * 2 * w + side * w, to = std::size_t(y) * w;
        for (int x = 0; x < w; ++x) {
          buffer[side].facing[to + x] = rgb[3 * (from + x)];
          buffer[side].surface[to + x] = rgb[3 * (from + x) + 1];
          buffer[side].depth_mm[to + x] = nf / (f - z[from + x] * range);
        }
      }
  }

  CameraModel camera;
  LensDistortion lens;
  vtkNew<vtkRenderWindow> window;
  vtkNew<vtkRenderer> renderer[2];
  vtkNew<vtkCamera> vtk_camera;
  std::vector<std::unique_ptr<BufferActor>> actors[2];
  vtkNew<vtkUnsignedCharArray> pixels;
  vtkNew<vtkFloatArray> depth;
  GeometryBuffer buffer[2];
};

GeometryBuffers::GeometryBuffers(const CameraModel& camera)
    : implementation_(std::make_unique<Implementation>(camera)) {}
GeometryBuffers::~GeometryBuffers() = default;
const GeometryBuffer& GeometryBuffers::Front() const { return implementation_->buffer[0]; }
const GeometryBuffer& GeometryBuffers::Inside() const { return implementation_->buffer[1]; }

void GeometryBuffers::Render(const std::vector<Part>& front, const std::vector<Part>& inside) {
  double near_mm = 1e9, far_mm = kNearest_mm;
  implementation_->Update(0, front, &near_mm, &far_mm);
  implementation_->Update(1, inside, &near_mm, &far_mm);
  near_mm = std::max(0.5 * kNearest_mm, 0.98 * std::min(near_mm, far_mm));
  far_mm = std::max(1.02 * far_mm, near_mm + 1.0);
  SetLensCamera(implementation_->lens.IdealPinhole(), near_mm, far_mm, implementation_->vtk_camera);
  implementation_->window->Render();
  implementation_->Read(near_mm, far_mm);
}

}  // namespace kerf
