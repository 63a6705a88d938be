#include "Pipelines/ValidationPictures.h"

#include <fmt/format.h>

#include <filesystem>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/Rendering/ErrorMap.h"
#include "Adapters/Rendering/VirtualDisplay.h"
#include "Geometry/SurfaceTree.h"
#include "Pipelines/OverlayRecorder.h"
#include "Pipelines/Report.h"
#include "Pipelines/TruthFiles.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

constexpr double kLargestError_mm = 5.0;
constexpr int kWidth = 640, kHeight = 400;

Eigen::VectorXd DistancesTo(const SurfaceMesh& truth, const SurfaceMesh& surface) {
  const SurfaceTree tree(truth);
  Eigen::VectorXd distance(surface.points.rows());
  for (Index v = 0; v < surface.points.rows(); ++v)
    distance[v] = tree.Closest(surface.points.row(v)).distance_mm;
  return distance;
}

}  // namespace

std::vector<std::pair<Image, std::string>> PicturesOf(const ValidationRun& run,
                                                      const std::string& study) {
  std::vector<std::pair<Image, std::string>> pictures;
  if (!run.error.empty() || run.scores.frames.empty() || !RenderingAvailable()) return pictures;
  const std::string name = run.study + ", " + run.variant.Name();
  if (run.replay.report && !run.replay.report->snapshots.empty()) {
    const ReportSnapshot& last = run.replay.report->snapshots.back();
    pictures.push_back({last.image, fmt::format("{}: overlay in frame {}", name, last.frame)});
  }
  const int frame = run.scores.frames.back().frame;
  const std::string ours = FindFrameMesh(run.results, frame, "organ"),
                    truth = FindFrameMesh((fs::path(study) / "truth").string(), frame, "organ");
  if (ours.empty() || truth.empty()) return pictures;
  const SurfaceMesh organ = ReadFrameSurface(ours).surface;
  const Eigen::VectorXd error = DistancesTo(ReadFrameSurface(truth).surface, organ);
  const CameraModel camera = ReadCameraFile((fs::path(run.results) / "camera.yml").string());
  const std::lock_guard lock(OverlayRecorder::Drawing());
  for (const auto& [view, where] : {std::pair{ErrorMapView::FromCamera, "from the camera"},
                                    std::pair{ErrorMapView::FromTheRight, "from its right"}})
    pictures.push_back(
        {RenderErrorMap(organ, error, kLargestError_mm, camera, view, kWidth, kHeight),
         fmt::format("{}: distance to the true surface in frame {}, {}", name, frame, where)});
  return pictures;
}

}  // namespace kerf
