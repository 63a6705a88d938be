#include "Pipelines/ExposureRegistration.h"

#include <algorithm>
#include <cmath>

#include "Adapters/OpenCv/LandmarkRegistration.h"
#include "Adapters/OpenCv/OrganSegmentation.h"
#include "Core/Errors.h"
#include "Core/Features.h"
#include "Registration/OrganMask.h"
#include "Registration/OutlinePose.h"

namespace kerf {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegreesPerPixel = 0.35;
constexpr double kFillsImage =
    0.55;  // share of the width that the organ takes where no pose is known
/// What the outline alone leaves open stays near where the surgeon has it.
constexpr double kFreely_deg = 10.0, kFreely_mm = 20.0;
constexpr std::size_t kHistory = 200;

}  // namespace

ExposureRegistration::ExposureRegistration(const CameraModel& intrinsics, const TetMesh& mesh,
                                           const std::vector<MarkupPoint>& landmarks,
                                           const std::optional<Eigen::Isometry3d>& given)
    : camera_(intrinsics), mesh_(mesh), organ_(BoundarySurface(mesh, mesh.rest)), given_(given) {
  center_ = organ_.points.colwise().mean().transpose();
  for (const MarkupPoint& point : landmarks)
    landmarks_.push_back({point.label, point.position_mm, {}, false, false});
  if (given_) {
    camera_.camera_from_world = *given_;
    ways_.push_back("given");
  } else {  // from the front (A → P), head up, in the middle of the picture
    const double extent =
        (organ_.points.colwise().maxCoeff() - organ_.points.colwise().minCoeff()).maxCoeff();
    Mat3 axes;
    axes << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    camera_.camera_from_world = Eigen::Isometry3d::Identity();
    camera_.camera_from_world.linear() = axes;
    const double depth = camera_.fx * extent / (kFillsImage * camera_.width);
    camera_.camera_from_world.translation() = Vec3(0, 0, depth) - axes * center_;
    ways_.push_back("by hand");
  }
  if (!landmarks_.empty()) advice_ = "Four landmarks are needed.";
}

void ExposureRegistration::Remember(const std::string& way) {
  history_.push_back({camera_.camera_from_world, landmarks_, advice_, ways_.size()});
  if (history_.size() > kHistory) history_.erase(history_.begin());
  if (ways_.empty() || ways_.back() != way) ways_.push_back(way);
}

void ExposureRegistration::Undo() {
  if (history_.empty()) return;
  Before& before = history_.back();
  camera_.camera_from_world = before.pose;
  landmarks_ = before.landmarks;
  advice_ = before.advice;
  ways_.resize(before.ways);
  history_.pop_back();
}

void ExposureRegistration::UseGiven() {
  if (!given_) return;
  Remember("given");
  camera_.camera_from_world = *given_;
}

int ExposureRegistration::NextLandmark() const {
  for (std::size_t i = 0; i < landmarks_.size(); ++i)
    if (!landmarks_[i].pixel) return static_cast<int>(i);
  return -1;
}

void ExposureRegistration::Place(int landmark, const Vec2& pixel) {
  if (landmark < 0 || landmark >= static_cast<int>(landmarks_.size())) return;
  Remember("landmarks");
  landmarks_[landmark].pixel = pixel;
  SolveLandmarks();
}

void ExposureRegistration::Remove(int landmark) {
  if (landmark < 0 || landmark >= static_cast<int>(landmarks_.size())) return;
  Remember("landmarks");
  landmarks_[landmark].pixel.reset();
  SolveLandmarks();
}

void ExposureRegistration::Exclude(int landmark, bool excluded) {
  if (landmark < 0 || landmark >= static_cast<int>(landmarks_.size())) return;
  Remember("landmarks");
  landmarks_[landmark].excluded = excluded;
  SolveLandmarks();
}

void ExposureRegistration::SolveLandmarks() {
  std::vector<int> used;
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    ExposureLandmark& landmark = landmarks_[i];
    landmark.residual_px = landmark.residual_mm = std::numeric_limits<double>::quiet_NaN();
    landmark.outlier = false;
    if (landmark.pixel && !landmark.excluded) used.push_back(static_cast<int>(i));
  }
  rms_px_ = std::numeric_limits<double>::quiet_NaN();
  if (used.size() < 4) {
    const int missing = 4 - static_cast<int>(used.size());
    advice_ = missing == 4 ? "Four landmarks are needed."
                           : std::to_string(missing) + " more landmark" +
                                 (missing == 1 ? " is" : "s are") + " needed.";
    return;
  }
  Points world(used.size(), 3);
  Pixels pixels(used.size(), 2);
  for (std::size_t k = 0; k < used.size(); ++k) {
    world.row(k) = landmarks_[used[k]].rest.transpose();
    pixels.row(k) = landmarks_[used[k]].pixel->transpose();
  }
  try {
    const LandmarkResult result = RegisterLandmarks(world, pixels, camera_);
    camera_.camera_from_world = result.camera.camera_from_world;
    advice_ = result.warning;
    rms_px_ = result.rms_px;
    for (const Index row : result.outliers) landmarks_[used[row]].outlier = true;
    // Those that were left out are shown, too: the surgeon sees how far off they are.
    for (ExposureLandmark& landmark : landmarks_) {
      if (!landmark.pixel) continue;
      landmark.residual_px = (camera_.Project(landmark.rest) - *landmark.pixel).norm();
      landmark.residual_mm = landmark.residual_px * camera_.Depth(landmark.rest) / camera_.fx;
    }
  } catch (const InputError& error) {
    advice_ = error.what();
  }
}

void ExposureRegistration::Drag(const Vec2& from, const Vec2& to) {
  Remember("by hand");
  const double depth = camera_.Depth(center_);
  const Vec2 by = (camera_.Undistort(to) - camera_.Undistort(from)) * depth;
  camera_.camera_from_world.pretranslate(Vec3(by.x(), by.y(), 0.0));
}

void ExposureRegistration::Turn(const Vec2& by_px) {
  if (by_px.norm() < 1e-9) return;
  Remember("by hand");
  const Vec3 axis(-by_px.y(), by_px.x(), 0.0);  // camera frame: y down, z forward
  const Eigen::AngleAxisd turn(-by_px.norm() * kDegreesPerPixel * kPi / 180.0, axis.normalized());
  const Vec3 at = camera_.camera_from_world * center_;
  camera_.camera_from_world.linear() = turn * camera_.camera_from_world.linear();
  camera_.camera_from_world.translation() += at - camera_.camera_from_world * center_;
}

void ExposureRegistration::Roll(double degrees) {
  Remember("by hand");
  const Vec3 at = camera_.camera_from_world * center_;
  camera_.camera_from_world.linear() =
      Eigen::AngleAxisd(degrees * kPi / 180.0, Vec3::UnitZ()) * camera_.camera_from_world.linear();
  camera_.camera_from_world.translation() += at - camera_.camera_from_world * center_;
}

void ExposureRegistration::Approach(double factor) {
  Remember("by hand");
  const Vec3 at = camera_.camera_from_world * center_;
  camera_.camera_from_world.pretranslate(at * (std::clamp(factor, 0.5, 2.0) - 1.0));
}

void ExposureRegistration::Trace(const Pixels& outline) {
  traced_ = {};
  if (outline.rows() < 3) return;
  ways_.push_back("outline traced");
  traced_.width = camera_.width;
  traced_.height = camera_.height;
  traced_.channels = 1;
  traced_.data.assign(std::size_t(traced_.width) * traced_.height, OrganSegmenter::kGround);
  std::vector<double> crossings;
  for (int y = 0; y < traced_.height; ++y) {  // even-odd filling, row by row
    crossings.clear();
    for (Index i = 0; i < outline.rows(); ++i) {
      const auto a = outline.row(i), b = outline.row((i + 1) % outline.rows());
      if ((a[1] <= y) == (b[1] <= y)) continue;
      crossings.push_back(a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]));
    }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
      const int from = std::max(0, int(std::ceil(crossings[k])));
      const int to = std::min(traced_.width - 1, int(std::floor(crossings[k + 1])));
      for (int x = from; x <= to; ++x)
        traced_.data[std::size_t(y) * traced_.width + x] = OrganSegmenter::kOrgan;
    }
  }
}

Image ExposureRegistration::Seen(const Frame& frame, const Image& model) const {
  return IsTraced() ? traced_ : OrganMask(frame, model);
}

double ExposureRegistration::ContourFit(const Frame& frame) const {
  const Image model = ProjectedMask(organ_, camera_);
  const Image seen = Seen(frame, model);
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < model.data.size() && i < seen.data.size(); ++i) {
    if (seen.data[i] == OrganSegmenter::kHidden) continue;
    both += model.data[i] && seen.data[i];
    either += model.data[i] || seen.data[i];
  }
  return either == 0 ? 0.0 : double(both) / double(either);
}

double ExposureRegistration::RefineByContour(const Frame& frame) {
  Remember("contour");
  const double before = ContourFit(frame);
  const Eigen::Isometry3d pose = camera_.camera_from_world;
  OutlinePoseOptions options;
  options.turn_deg = kFreely_deg;
  options.shift_mm = kFreely_mm;
  camera_.camera_from_world =
      FitPoseToOutline(
          mesh_, camera_, [&](const Image& model) { return Seen(frame, model); }, options)
          .camera_from_world;
  const double after = ContourFit(frame);
  if (after >= before) return after;
  camera_.camera_from_world = pose;
  return before;
}

JournalData ExposureRegistration::Description() const {
  JournalData data{{"ways", ways_}};
  std::vector<double> residuals;
  std::vector<std::string> names, left_out;
  for (const ExposureLandmark& landmark : landmarks_) {
    if (!landmark.pixel) continue;
    names.push_back(landmark.name);
    residuals.push_back(std::isfinite(landmark.residual_px) ? landmark.residual_px : -1.0);
    if (landmark.excluded) left_out.push_back(landmark.name);
  }
  if (!names.empty()) {
    data.push_back({"landmarks", names});
    data.push_back({"residual_px", residuals});
    data.push_back({"excluded", left_out});
    if (std::isfinite(rms_px_)) data.push_back({"rms_px", rms_px_});
  }
  return data;
}

}  // namespace kerf
