#include "Pipelines/PhantomPipeline.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "Adapters/Ffmpeg/VideoWriter.h"
#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/Rendering/ImageEncoding.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/Csv.h"
#include "CaseIO/Space.h"
#include "Core/Errors.h"
#include "Phantom/Noise.h"
#include "Phantom/PhantomCt.h"
#include "Phantom/PhantomScene.h"
#include "Pipelines/PhantomFiles.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

/// A folder that is made beside its final place and moved there when complete.
class FolderInTheMaking {
 public:
  explicit FolderInTheMaking(const std::string& path)
      : final_(fs::absolute(path).lexically_normal()) {
    if (final_.filename().empty()) final_ = final_.parent_path();
    std::error_code error;
    if (fs::exists(final_, error)) {
      if (!fs::is_directory(final_)) throw InputError(path, "", "is a file, not a folder");
      if (!fs::is_empty(final_) && !IsStudy(final_))
        throw UsageError(path + ": is not empty and not a study; choose another --output");
    }
    making_ = final_.parent_path() /
              ("." + final_.filename().string() + fmt::format(".partial-{}", getpid()));
    fs::create_directories(making_ / "truth", error);
    if (error) throw InputError(path, "", "cannot be made: " + error.message());
  }
  ~FolderInTheMaking() {
    std::error_code error;
    if (!done_) fs::remove_all(making_, error);
  }
  FolderInTheMaking(const FolderInTheMaking&) = delete;
  FolderInTheMaking& operator=(const FolderInTheMaking&) = delete;

  std::string operator/(const std::string& name) const { return (making_ / name).string(); }
  void Finish() {
    std::error_code error;
    fs::remove_all(final_, error);
    if (!error) fs::rename(making_, final_, error);
    if (error) throw InputError(final_.string(), "", "cannot be replaced: " + error.message());
    done_ = true;
  }

 private:
  static bool IsStudy(const fs::path& folder) {
    std::ifstream file(folder / "case.json");
    const auto json = nlohmann::json::parse(file, nullptr, false);
    return json.is_object() && json.value("format", "") == "kerf-study";
  }
  fs::path final_, making_;
  bool done_ = false;
};

/// All features, with rows in the order of their ids; the first `feature_count` are the ones to
/// use.
class FeatureFiles {
 public:
  FeatureFiles(const FolderInTheMaking& folder, const PhantomSetup& setup,
               const PhantomFeatures& features)
      : setup_(setup),
        features_(features),
        tracks_(folder / "features_2d.csv", {"frame", "id", "u_px", "v_px", "visible"}),
        truth_(folder / "truth/tracks.csv",
               {"frame", "id", "u_px", "v_px", "visible", "x_mm", "y_mm", "z_mm"}) {}

  void Add(int frame, bool evaluated, const PhantomTracks& tracks) {
    for (int id = 0; id < static_cast<int>(features_.rest.rows()); ++id) {
      if (id < setup_.feature_count)
        (tracks_ << frame << id).Fixed(tracks.pixels(id, 0), 3).Fixed(tracks.pixels(id, 1), 3)
            << int(tracks.visible[id]);
      if (!evaluated) continue;
      const Vec3 p = FlipSpace(Vec3(tracks.world.row(id)));
      (truth_ << frame << id).Fixed(tracks.pixels(id, 0), 3).Fixed(tracks.pixels(id, 1), 3)
          << int(tracks.visible[id]);
      truth_.Fixed(p.x(), 4).Fixed(p.y(), 4).Fixed(p.z(), 4);
    }
  }
  void Finish() {
    tracks_.Finish();
    truth_.Finish();
  }

 private:
  const PhantomSetup& setup_;
  const PhantomFeatures& features_;
  CsvWriter tracks_, truth_;
};

void WriteRestFeatures(const std::string& path, const PhantomSetup& setup,
                       const PhantomTracks& first) {
  CsvWriter csv(path, {"id", "use", "x_mm", "y_mm", "z_mm", "u_px", "v_px"});
  for (int id = 0; id < static_cast<int>(first.world.rows()); ++id) {
    const Vec3 p = FlipSpace(Vec3(first.world.row(id)));
    (csv << id << int(id < setup.feature_count)).Fixed(p.x(), 4).Fixed(p.y(), 4).Fixed(p.z(), 4);
    csv.Fixed(first.pixels(id, 0), 3).Fixed(first.pixels(id, 1), 3);
  }
  csv.Finish();
}

/// Eight landmarks; with the noise that picking them in a CT and in an image has: 0.5 mm and 1 px.
void WriteLandmarks(const FolderInTheMaking& folder, const PhantomSetup& setup,
                    const PhantomFeatures& features, const PhantomTracks& first) {
  const std::vector<std::string> header{"id", "x_mm", "y_mm", "z_mm", "u_px", "v_px"};
  CsvWriter noisy(folder / "landmarks.csv", header),
      exact(folder / "truth/landmarks_exact.csv", header);
  int id = 0;
  for (Index row : ChooseLandmarks(features, 8)) {
    auto noise = [&](std::uint32_t axis, double size) {
      return size * NormalFromHash(Hash(static_cast<std::uint32_t>(id), axis, 99, setup.seed));
    };
    const Vec3 p = FlipSpace(Vec3(first.world.row(row)));
    const double mm = 0.5 / std::sqrt(3.0), px = 1.0 / std::sqrt(2.0);
    (exact << id).Fixed(p.x(), 3).Fixed(p.y(), 3).Fixed(p.z(), 3);
    exact.Fixed(first.pixels(row, 0), 3).Fixed(first.pixels(row, 1), 3);
    (noisy << id)
        .Fixed(p.x() + noise(0, mm), 3)
        .Fixed(p.y() + noise(1, mm), 3)
        .Fixed(p.z() + noise(2, mm), 3);
    noisy.Fixed(first.pixels(row, 0) + noise(3, px), 2)
        .Fixed(first.pixels(row, 1) + noise(4, px), 2);
    ++id;
  }
  noisy.Finish();
  exact.Finish();
}

SurfaceMesh InWorld(SurfaceMesh surface, const PhantomSetup& setup) {
  surface.points = ToWorld(surface.points, setup.world_from_organ);
  return surface;
}

void WriteTrueSurfaces(const FolderInTheMaking& folder, const PhantomSetup& setup,
                       const PhantomAnatomy& anatomy, const PhantomMotion& motion, int frame,
                       const Image& mask) {
  auto name = [&](const char* what) {
    return folder / fmt::format("truth/frame_{:05d}_{}", frame, what);
  };
  const PhantomSurfaceAtFrame organ = OrganAtFrame(anatomy, motion, frame);
  WriteSurfaceWithArrays(InWorld(organ.mesh, setup), name("organ.vtp"), Space::RAS,
                         {{"pid", organ.pid}});
  if (!anatomy.internal.Empty())
    WriteSurface(InWorld(StructureAtFrame(anatomy.internal, motion, frame), setup),
                 name("internal.vtp"), Space::RAS);
  if (!anatomy.tumour.Empty())
    WriteSurface(InWorld(StructureAtFrame(anatomy.tumour, motion, frame), setup),
                 name("tumour.vtp"), Space::RAS);
  WritePng(name("mask.png"), mask);
}

void WriteRest(const FolderInTheMaking& folder, const PhantomSetup& setup,
               const PhantomAnatomy& anatomy, const PhantomMotion& motion) {
  WriteSurfaceWithArrays(InWorld(anatomy.organ, setup), folder / "truth/rest_organ.vtp", Space::RAS,
                         {{"cut", anatomy.organ_cut}, {"region", anatomy.organ_region}});
  if (!anatomy.internal.Empty())
    WriteSurface(InWorld(anatomy.internal, setup), folder / "truth/rest_internal.vtp", Space::RAS);
  if (!anatomy.tumour.Empty())
    WriteSurface(InWorld(anatomy.tumour, setup), folder / "truth/rest_tumour.vtp", Space::RAS);
  for (int cut = 0; cut < motion.CutCount(); ++cut) {
    std::vector<float> depth;
    const SurfaceMesh sheet = OpenedSheet(anatomy, motion, cut, setup.frame_count - 1, &depth);
    WriteSurfaceWithArrays(InWorld(sheet, setup),
                           folder / fmt::format("truth/cut{}_surface_rest.vtp", cut), Space::RAS,
                           {{"depth", depth}});
  }
  WriteTrueCuts(folder / "truth/cuts.json", setup, motion);
  WriteStudyCamera(folder / "camera.yml", setup.camera,
                   "T_cam_from_ct maps the CT frame (RAS, mm) to the OpenCV camera frame");
  WriteStudyCamera(folder / "truth/camera_true.yml", setup.camera, "exact pose used for the video");
}

}  // namespace

PhantomResult MakePhantom(const PhantomRequest& request, Progress& progress) {
  FolderInTheMaking folder(request.output);
  const PhantomSetup setup = MakePhantomSetup(request.scenario, request.seed);
  const PhantomMotion motion(setup.motion);
  progress.Report(0.0, "shaping the organ");
  const PhantomAnatomy anatomy = BuildPhantomAnatomy(setup);
  WriteRest(folder, setup, anatomy, motion);
  if (setup.is_kidney) {
    progress.Report(0.03, "scanning (CT)");
    const PhantomCt ct = MakePhantomCt(setup, progress);
    WriteVolume(folder / "ct.nii.gz", ct.ct);
    WriteLabelMap(folder / "labels.nii.gz", ct.labels);
    WriteStudyManifest(folder / "case.json", setup, anatomy, &ct.labels);
  } else {
    PhantomSetup uncut = setup;
    uncut.motion.cuts.clear();
    WriteSurface(InWorld(BuildPhantomAnatomy(uncut).organ, setup), folder / "organ_surface.stl",
                 Space::RAS);
    WriteBandDimensions(folder / "dims.json", setup);
    WriteStudyManifest(folder / "case.json", setup, anatomy, nullptr);
  }

  const PhantomScene scene(setup, anatomy);
  const PhantomFeatures features = ChooseFeatures(setup, anatomy, scene.Render(0, false), 300);
  FeatureFiles feature_files(folder, setup, features);
  VideoWriter video(folder / "video.mp4", setup.camera.width, setup.camera.height,
                    setup.frames_per_second);
  if (!video.Message().empty()) progress.Warn(video.Message());
  std::size_t next = 0;
  for (int frame = 0; frame < setup.frame_count; ++frame) {
    progress.ThrowIfCancelled();
    progress.Report(0.1 + 0.9 * frame / setup.frame_count, "filming");
    const PhantomView view = scene.Render(frame, true);
    video.Write(view.image);
    const PhantomTracks tracks = TrackFeatures(setup, features, view, frame);
    const bool evaluated = next < setup.eval_frames.size() && setup.eval_frames[next] == frame;
    if (evaluated) {
      ++next;
      WriteTrueSurfaces(folder, setup, anatomy, motion, frame, view.mask);
    }
    feature_files.Add(frame, evaluated, tracks);
    if (frame == 0) {
      WriteRestFeatures(folder / "features_rest.csv", setup, tracks);
      WriteLandmarks(folder, setup, features, tracks);
    }
  }
  feature_files.Finish();
  video.Finish();
  folder.Finish();
  PhantomResult result{setup.frame_count, 0.0};
  for (int cut = 0; cut < motion.CutCount(); ++cut)
    result.final_opening_mm =
        std::max(result.final_opening_mm, motion.Opening_mm(0.0, setup.frame_count - 1, cut));
  return result;
}

}  // namespace kerf
