#include "Adapters/Rendering/GeometryBuffers.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCullerCollection.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
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

#include "Adapters/Rendering/DisplayProbe.h"
#include "Adapters/Rendering/LensCamera.h"
#include "Adapters/Rendering/vtkKerfLensWarp.h"

// Registers VTK's OpenGL and FreeType factories for whoever links this library, however it was
// linked.
#include <vtkAutoInit.h>
VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)

namespace kerf {
namespace {

// One surface of the scene as a VTK pipeline: source → lens → mapper. Keeps its connectivity from
// frame to frame and only moves the points while it is the same.
class BufferActor {
 public:
  BufferActor() {
    cut_flags_->SetName("cut_face");
    source_->SetPoints(points_);
    source_->GetCellData()->AddArray(cut_flags_);
    points_->SetDataTypeToDouble();
    lens_->SetInputData(source_);
    mapper_->SetInputConnection(lens_->GetOutputPort());
    mapper_->SetColorModeToDirectScalars();
    mapper_->SetScalarModeToUsePointData();
    actor_->SetMapper(mapper_);
    actor_->GetProperty()->LightingOff();
    actor_->GetProperty()->SetInterpolationToFlat();
  }
  vtkActor* Actor() { return actor_; }
  void SetLens(const CameraModel& camera) { lens_->SetLens(camera); }

  // Extends [near, far] by the depths of what can be seen, and the box by where it is.
  void Update(const GeometryBuffers::Part& part, double* near_mm, double* far_mm, PixelBox* box) {
    const Points& p = part.mesh->points;
    points_->SetNumberOfPoints(p.rows());
    std::copy_n(p.data(), p.size(), static_cast<double*>(points_->GetVoidPointer(0)));
    points_->Modified();
    UpdateCells(part);
    source_->Modified();
    if (lens_->GetSurfaceClass() != part.surface) lens_->SetSurfaceClass(part.surface);
    lens_->SetCutFaceClass(GeometryBuffers::CutFace);
    lens_->Update();
    actor_->GetProperty()->SetBackfaceCulling(lens_->GetSolid());
    *near_mm = std::min(*near_mm, lens_->GetDepthRange()[0]);
    *far_mm = std::max(*far_mm, lens_->GetDepthRange()[1]);
    const double* at = lens_->GetScreenRange();
    if (at[0] > at[1]) return;
    const int width = lens_->GetLens().width, height = lens_->GetLens().height;
    const auto inside = [](double v, int size) {
      return static_cast<int>(std::clamp(v, 0.0, size - 1.0));
    };
    if (at[1] < 0 || at[3] < 0 || at[0] > width - 1 || at[2] > height - 1) return;
    box->Include(inside(std::floor(at[0]) - 1, width), inside(std::floor(at[2]) - 1, height));
    box->Include(inside(std::ceil(at[1]) + 1, width), inside(std::ceil(at[3]) + 1, height));
  }

 private:
  void UpdateCells(const GeometryBuffers::Part& part) {
    const Triangles& triangles = part.mesh->triangles;
    const std::vector<std::uint8_t> none;
    const std::vector<std::uint8_t>& cut = part.cut_face ? *part.cut_face : none;
    if (cut == cut_ && triangles.rows() == triangles_.rows() && triangles == triangles_) return;
    triangles_ = triangles;
    cut_ = cut;
    vtkNew<vtkIdTypeArray> connectivity, offsets;
    connectivity->SetNumberOfValues(triangles.size());
    offsets->SetNumberOfValues(triangles.rows() + 1);
    std::copy_n(triangles.data(), triangles.size(), connectivity->GetPointer(0));
    for (Index t = 0; t <= triangles.rows(); ++t) offsets->SetValue(t, 3 * t);
    vtkNew<vtkCellArray> cells;
    cells->SetData(offsets, connectivity);
    source_->SetPolys(cells);
    cut_flags_->SetNumberOfTuples(triangles.rows());
    cut_flags_->Fill(0);
    for (std::size_t t = 0; t < cut.size(); ++t)
      cut_flags_->SetValue(static_cast<vtkIdType>(t), cut[t]);
    cut_flags_->Modified();
  }

  vtkNew<vtkPoints> points_;
  vtkNew<vtkUnsignedCharArray> cut_flags_;
  vtkNew<vtkPolyData> source_;
  vtkNew<vtkKerfLensWarp> lens_;
  vtkNew<vtkPolyDataMapper> mapper_;
  vtkNew<vtkActor> actor_;
  Triangles triangles_;
  std::vector<std::uint8_t> cut_;
};

void Prepare(GeometryBuffer* buffer, int width, int height) {
  buffer->width = width;
  buffer->height = height;
  const std::size_t n = std::size_t(width) * height;
  buffer->surface.resize(n);
  buffer->facing.resize(n);
  buffer->depth_mm.resize(n);
  buffer->box = {0, 0, width, height};  // what is in it is of another size
}

}  // namespace

struct GeometryBuffers::Implementation {
  explicit Implementation(const CameraModel& c) {
    SetCamera(c);
    window->SetOffScreenRendering(1);
    window->SetMultiSamples(0);
    window->SwapBuffersOff();  // nobody looks at the window: only its buffers are read
    window->Start();           // connects
    SurviveDisplayLoss(window->GetGenericDisplayId());
    for (int side = 0; side < 2; ++side) {
      renderer[side]->SetViewport(0.5 * side, 0, 0.5 * side + 0.5, 1);
      renderer[side]->SetBackground(0, 0, 0);
      renderer[side]->SetActiveCamera(vtk_camera);
      renderer[side]->GetCullers()->RemoveAllItems();  // next to everything is in the picture
      window->AddRenderer(renderer[side]);
    }
  }

  void SetCamera(const CameraModel& c) {
    camera = c;
    ideal = LensDistortion(c).IdealPinhole();
    for (int side = 0; side < 2; ++side) {
      for (auto& actor : actors[side]) actor->SetLens(c);
      Prepare(&buffer[side], c.width, c.height);
    }
    window->SetSize(2 * c.width, c.height);
  }

  void Update(int side, const std::vector<Part>& parts, double* near_mm, double* far_mm,
              PixelBox* box) {
    while (actors[side].size() < parts.size()) {
      actors[side].push_back(std::make_unique<BufferActor>());
      actors[side].back()->SetLens(camera);
      renderer[side]->AddActor(actors[side].back()->Actor());
    }
    for (std::size_t i = 0; i < actors[side].size(); ++i) {
      const bool shown = i < parts.size() && parts[i].mesh && !parts[i].mesh->Empty();
      actors[side][i]->Actor()->SetVisibility(shown);
      if (shown) actors[side][i]->Update(parts[i], near_mm, far_mm, box);
    }
  }

  /// Reading back costs as much as drawing: only the boxes are.
  void Read(const PixelBox (&boxes)[2], double near_mm, double far_mm) {
    const int w = camera.width, h = camera.height;
    const float nf = static_cast<float>(near_mm * far_mm), f = static_cast<float>(far_mm),
                range = static_cast<float>(far_mm - near_mm);
    for (int side = 0; side < 2; ++side) {
      const PixelBox& box = boxes[side];
      const int columns = box.x1 - box.x0;
      GeometryBuffer& out = buffer[side];
      for (int y = out.box.y0; y < out.box.y1; ++y)
        std::fill_n(out.surface.begin() + std::size_t(y) * w + out.box.x0, out.box.x1 - out.box.x0,
                    std::uint8_t(GeometryBuffers::Nothing));
      out.box = box;
      if (box.Empty()) continue;
      const int x = side * w + box.x0;
      // With alpha, as it is stored: without it every pixel would be taken apart.
      window->GetRGBACharPixelData(x, h - box.y1, x + columns - 1, h - 1 - box.y0, 0, pixels);
      window->GetZbufferData(x, h - box.y1, x + columns - 1, h - 1 - box.y0, depth);
      for (int row = box.y0; row < box.y1; ++row) {
        const std::size_t from = std::size_t(box.y1 - 1 - row) * columns;
        const std::size_t to = std::size_t(row) * w + box.x0;
        const unsigned char* rgba = pixels->GetPointer(0) + 4 * from;
        const float* z = depth->GetPointer(0) + from;
        for (int i = 0; i < columns; ++i) {
          out.facing[to + i] = rgba[4 * i];
          out.surface[to + i] = rgba[4 * i + 1];
          out.depth_mm[to + i] = nf / (f - z[i] * range);
        }
      }
    }
  }

  CameraModel camera;
  CameraModel ideal;
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
void GeometryBuffers::SetCamera(const CameraModel& camera) { implementation_->SetCamera(camera); }
const GeometryBuffer& GeometryBuffers::Front() const { return implementation_->buffer[0]; }
const GeometryBuffer& GeometryBuffers::Inside() const { return implementation_->buffer[1]; }

void GeometryBuffers::Render(const std::vector<Part>& front, const std::vector<Part>& inside) {
  double near_mm = 1e9, far_mm = vtkKerfLensWarp::NearestDepth;
  PixelBox boxes[2];
  implementation_->Update(0, front, &near_mm, &far_mm, &boxes[0]);
  implementation_->Update(1, inside, &near_mm, &far_mm, &boxes[1]);
  near_mm = std::max(0.5 * vtkKerfLensWarp::NearestDepth, 0.98 * std::min(near_mm, far_mm));
  far_mm = std::max(1.02 * far_mm, near_mm + 1.0);
  SetLensCamera(implementation_->ideal, near_mm, far_mm, implementation_->vtk_camera);
  implementation_->window->Render();
  implementation_->Read(boxes, near_mm, far_mm);
}

}  // namespace kerf
