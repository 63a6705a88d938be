#include "Adapters/Rendering/OverlayRenderer.h"

#include <stdexcept>
#include <string>
#include <vector>

#include "Adapters/Rendering/GeometryBuffers.h"
#include "Adapters/Rendering/OverlayCompositor.h"
#include "Adapters/Rendering/OverlayStatusPanel.h"
#include "Adapters/Rendering/VirtualDisplay.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

void Check(const CameraModel& camera, const OverlayScene& scene) {
  const std::string which = "frame " + std::to_string(scene.frame.index);
  const auto check_size = [&](const Image& image, int channels, const char* what) {
    if (image.width != camera.width || image.height != camera.height)
      throw InputError("overlay", which,
                       std::string(what) + " is " + std::to_string(image.width) + "x" +
                           std::to_string(image.height) + ", the camera " +
                           std::to_string(camera.width) + "x" + std::to_string(camera.height));
    if ((image.channels != channels && image.channels != 1) ||
        image.data.size() != std::size_t(image.width) * image.height * image.channels)
      throw InputError("overlay", which, std::string(what) + " has an unexpected pixel format");
  };
  if (scene.frame.image) check_size(*scene.frame.image, 3, "the video frame");
  if (scene.instruments) check_size(*scene.instruments, 1, "the instrument mask");
  const auto check_mesh = [&](const SurfaceMesh* mesh, const char* what) {
    if (!mesh || mesh->Empty()) return;
    if (!mesh->points.allFinite())
      throw InputError("overlay", which, std::string(what) + " has a point that is not a number");
    if (mesh->triangles.minCoeff() < 0 || mesh->triangles.maxCoeff() >= mesh->points.rows())
      throw InputError("overlay", which, std::string(what) + " refers to a point it does not have");
  };
  check_mesh(scene.organ, "the organ");
  for (const OverlayStructure& s : scene.structures) check_mesh(s.current, "an inner structure");
  for (const OverlayLine& line : scene.lines)
    if (!line.current.allFinite())
      throw InputError("overlay", which, "a line has a point that is not a number");
  if (scene.features && (scene.features->pixels.rows() != scene.features->Size() ||
                         Index(scene.features->status.size()) != scene.features->Size()))
    throw InputError("overlay", which, "the features' lists have different lengths");
  if (!scene.organ_cut_face.empty() &&
      (!scene.organ || Index(scene.organ_cut_face.size()) != scene.organ->triangles.rows()))
    throw InputError("overlay", which, "one cut-face flag is needed for each organ triangle");
}

Image Ground(const CameraModel& camera, const Frame& frame) {
  Image image;
  image.width = camera.width;
  image.height = camera.height;
  image.channels = 3;
  const std::size_t n = std::size_t(camera.width) * camera.height;
  if (!frame.image) {
    image.data.assign(3 * n, 40);
  } else if (frame.image->channels == 3) {
    image.data = frame.image->data;
  } else {
    image.data.resize(3 * n);
    for (std::size_t i = 0; i < n; ++i)
      for (int k = 0; k < 3; ++k) image.data[3 * i + k] = frame.image->data[i];
  }
  return image;
}

}  // namespace

struct OverlayRenderer::Implementation {
  Implementation(const CameraModel& c, const OverlayOptions& o)
      : camera(c), options(o), buffers(c), compositor(c.width, c.height) {}
  CameraModel camera;
  OverlayOptions options;
  GeometryBuffers buffers;
  OverlayCompositor compositor;
  TextPainter text;
};

OverlayRenderer::OverlayRenderer(const CameraModel& camera, const OverlayOptions& options) {
  camera.Validate("overlay camera");
  std::string why_not;
  if (!RenderingAvailable(&why_not)) throw std::runtime_error("overlay: " + why_not);
  implementation_ = std::make_unique<Implementation>(camera, options);
}
OverlayRenderer::~OverlayRenderer() = default;

void OverlayRenderer::SetOptions(const OverlayOptions& options) {
  implementation_->options = options;
}

void OverlayRenderer::SetCamera(const CameraModel& camera) {
  camera.Validate("overlay camera");
  Implementation& self = *implementation_;
  if (camera.width != self.camera.width || camera.height != self.camera.height) {
    implementation_ = std::make_unique<Implementation>(camera, self.options);
    return;
  }
  self.camera = camera;
  self.buffers.SetCamera(camera);
}

Image OverlayRenderer::Render(const OverlayScene& scene) {
  Implementation& self = *implementation_;
  Check(self.camera, scene);
  Image image = Ground(self.camera, scene.frame);
  if (scene.status.gate != OverlayStatus::Gate::Off) {
    std::vector<GeometryBuffers::Part> front, inside;
    if (scene.organ)
      front.push_back({scene.organ, GeometryBuffers::Outer,
                       scene.organ_cut_face.empty() ? nullptr : &scene.organ_cut_face});
    for (const OverlayStructure& s : scene.structures)
      inside.push_back({s.current,
                        s.kind == OverlayStructure::Kind::Tumour ? GeometryBuffers::Tumour
                                                                 : GeometryBuffers::Internal,
                        nullptr});
    self.buffers.Render(front, inside);
    self.compositor.Compose(self.camera, self.options, scene, self.buffers.Front(),
                            self.buffers.Inside(), &image);
  }
  DrawStatusPanel(self.options, scene, &self.text, &image);
  return image;
}

}  // namespace kerf
