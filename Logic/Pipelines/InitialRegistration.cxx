#include "Pipelines/InitialRegistration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/OpenCv/LandmarkRegistration.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "CaseIO/StudyFolder.h"
#include "Core/Errors.h"
#include "Pipelines/RegistrationParts.h"
#include "Registration/OutlinePose.h"

namespace kerf {
namespace {

constexpr double kAgrees_px = 1.5;   // right poses gave 0.7 to 1.3 px
constexpr double kFar_px = 8.0;      // worth a warning where no motion explains it
constexpr double kExplained = 0.75;  // what is left of the distance, at most
constexpr double kLikely = 2.0;      // standard deviations

}  // namespace

CameraModel InitialCamera(const ReplayRequest& request, const Study& study, Progress& progress,
                          JournalData* accepted, std::vector<LandmarkFit>* fits) {
  CameraModel camera = ReadCameraFile(study.camera);
  accepted->push_back({"source", request.registration == ReplayRequest::InitialPose::Given
                                     ? "camera.yml"
                                     : "landmarks.csv"});
  if (request.registration == ReplayRequest::InitialPose::Given) return camera;
  if (study.landmarks.empty())
    throw InputError(study.root, "landmarks.csv", "--registration landmarks, but there is none");
  const auto landmarks = ReadLandmarks(study.landmarks);
  Points world(landmarks.size(), 3);
  Pixels pixels(landmarks.size(), 2);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    world.row(i) = landmarks[i].rest.transpose();
    pixels.row(i) = landmarks[i].pixel.transpose();
  }
  const LandmarkResult result = RegisterLandmarks(world, pixels, camera, study.landmarks);
  if (!result.warning.empty()) progress.Warn(study.landmarks + ": " + result.warning);
  std::vector<double> residuals(result.residual_px.data(),
                                result.residual_px.data() + result.residual_px.size()),
      left_out;
  for (Index row : result.outliers) left_out.push_back(landmarks[row].id);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const bool outlier = std::count(result.outliers.begin(), result.outliers.end(), Index(i)) > 0;
    fits->push_back({landmarks[i].id, result.residual_px[i], result.residual_mm[i], outlier});
  }
  accepted->push_back({"residual_px", residuals});
  accepted->push_back({"rms_px", result.rms_px});
  accepted->push_back({"outlier_ids", left_out});
  camera.camera_from_world = result.camera.camera_from_world;
  return camera;
}

void RefineByOutline(const std::string& video, const TetMesh& mesh, Progress& progress,
                     CameraModel* camera, JournalData* accepted) {
  const auto first = OpenVideo(video)->Next();
  if (!first || !first->image) return;
  const auto segmenter = MakeVideoOrganSegmenter();
  OutlinePoseOptions options;
  options.turn_deg = 3.0;
  options.shift_mm = 4.0;
  const auto seen = [&](const Image& model) {
    progress.ThrowIfCancelled();
    return segmenter->Segment(*first, model);
  };
  const OutlinePose fit = FitPoseToOutline(mesh, *camera, seen, options);
  if (fit.points == 0) return;
  accepted->push_back({"outline_px", fit.before_px});
  if (fit.before_px <= kAgrees_px) return;
  const Vec3 center = mesh.rest.colwise().mean().transpose();
  const Eigen::Isometry3d motion = fit.camera_from_world * camera->camera_from_world.inverse();
  const double shift_mm =
      (fit.camera_from_world * center - camera->camera_from_world * center).norm();
  const double turn_deg = Eigen::AngleAxisd(motion.linear()).angle() * 180.0 / M_PI;
  const bool explained = fit.after_px <= kExplained * fit.before_px &&
                         shift_mm <= kLikely * options.shift_mm &&
                         turn_deg <= kLikely * options.turn_deg;
  if (!explained) {
    if (fit.before_px > kFar_px)
      progress.Warn(
          fmt::format("{}: in the first picture the organ's outline lies {:.0f} px from "
                      "the model's, and no small motion brings them together: check the "
                      "initial registration",
                      video, fit.before_px));
    return;
  }
  progress.Warn(
      fmt::format("the initial pose was moved by {:.1f} mm and turned by {:.1f} degrees: the "
                  "organ's outline lay {:.1f} px from the model's, now {:.1f} px (--outline off: "
                  "not looked at)",
                  shift_mm, turn_deg, fit.before_px, fit.after_px));
  accepted->push_back({"outline_after_px", fit.after_px});
  accepted->push_back({"outline_shift_mm", shift_mm});
  accepted->push_back({"outline_turn_deg", turn_deg});
  camera->camera_from_world = fit.camera_from_world;
}

}  // namespace kerf
