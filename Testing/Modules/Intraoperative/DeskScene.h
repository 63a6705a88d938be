#pragma once

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "CaseIO/StudyFolder.h"
#include "Pipelines/IntraoperativeDesk.h"

/// A planned phantom at the desk, without a window.
namespace kerf::testing {

template <class F>
bool Within(double seconds, F condition) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

/// The phantom's case in a folder of its own; gone with the object.
class PhantomCase {
 public:
  explicit PhantomCase(int tetrahedra)
      : folder_(std::filesystem::temp_directory_path() /
                ("kerf-desk-" + std::to_string(getpid()) + "-" + std::to_string(tetrahedra))) {
    MeshingOptions meshing;
    meshing.tetrahedra = tetrahedra;
    Progress silent;
    PlannedCase planned = PlanFromLabels(ReadLabelMap(OpenStudy(Study()).labels), meshing, silent);
    planned.camera = ReadCameraFile(Study() + "/camera.yml");
    WriteCase(planned, folder_.string());
  }
  ~PhantomCase() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  static std::string Study() { return KERF_TEST_PHANTOM; }
  std::string Folder() const { return folder_.string(); }
  /// Opens the case and the video, every frame of it as fast as it is registered.
  /// @param open the video in another way
  void OpenFor(IntraoperativeDesk* desk, IntraoperativeDesk::SourceOpener open = {}) const {
    CaptureOptions options;
    options.every = true;
    options.paced = false;
    options.hold = true;
    if (open)
      desk->SetSourceOpener(std::move(open), options);
    else
      desk->SetCaptureOptions(options);
    desk->OpenCase(Folder(), IntraoperativeDesk::ReadPlanned(Folder()));
    desk->OpenSource(Study() + "/video.mp4");
    if (!Within(20, [&] { return desk->Newest().has_value(); }))
      throw InputError(Study(), "video.mp4", "no picture came");
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace kerf::testing
