#include "Registration/OutlinePose.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "Registration/OrganMask.h"
#include "Registration/Silhouette.h"

namespace kerf {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

constexpr int kSteps = 30;
constexpr Index kLeastPoints = 12;
constexpr double kAsMuch = 0.8;         // of the outline's points that the given pose shows
constexpr double kNoise_px = 2.0;       // of an outline that is found by colour
constexpr double kNeighbours = 8.0;     // points of the outline that err together
constexpr double kLeastScale_px = 3.0;  // of the robust weights
constexpr double kDone_mm = 1e-3;
constexpr double kDegree = 3.14159265358979323846 / 180.0;

/// Camera pose after a small motion of the organ in the camera's frame: turned about `center`
/// (camera frame) by the vector of the first three, radians, then shifted by the last three, mm.
Eigen::Isometry3d Moved(const Eigen::Isometry3d& pose, const Vec6& motion, const Vec3& center) {
  const Vec3 turn = motion.head<3>();
  Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
  if (turn.norm() > 0) move.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).matrix();
  move.translation() = center - move.linear() * center + motion.tail<3>();
  return move * pose;
}

/// Mean of the smaller three quarters of the outline: finer than a median of whole pixels, and as
/// little disturbed by what hides it.
double TrimmedMean(const Eigen::VectorXd& values, const Eigen::VectorXd& weights) {
  std::vector<Index> order(values.size());
  std::iota(order.begin(), order.end(), Index(0));
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return values[a] < values[b]; });
  double sum = 0.0, total = 0.0;
  for (const Index i : order) {
    if (total >= 0.75 * weights.sum()) break;
    sum += weights[i] * values[i];
    total += weights[i];
  }
  return sum / std::max(total, 1e-12);
}

/// Where the two outlines differ.
struct Offsets {
  Points world;            ///< on the model's outline, mm
  Pixels at, normal;       ///< px; unit
  Eigen::VectorXd off_px;  ///< along the normal
  Eigen::VectorXd
      weights;  ///< length of the outline that each stands for, by how sure it is; mean 1
};

}  // namespace

OutlinePose FitPoseToOutline(const TetMesh& mesh, const CameraModel& given, const SeenOrgan& seen,
                             const OutlinePoseOptions& options) {
  const BoundaryTopology boundary = MakeBoundaryTopology(mesh, Points(0, 3));
  const SurfaceMesh organ = BoundarySurface(mesh, mesh.rest);
  const Vec3 center = given.camera_from_world * Vec3(mesh.rest.colwise().mean().transpose());
  const auto compare = [&](const CameraModel& camera) {
    const Image model = ProjectedMask(organ, camera);
    const Image organ_seen = seen(model);
    Offsets out;
    // A segmenter that has learnt nothing gives the projection back.
    if (organ_seen.data == model.data) return out;
    const SilhouetteTargets found =
        FindSilhouette(boundary, mesh, mesh.rest, camera, model, organ_seen, options.reach_px);
    out.world = found.at.Positions(mesh.rest, mesh.tets);
    out.weights = found.confidence.cwiseProduct(found.length_px);
    const Index n = out.world.rows();
    if (n > 0) out.weights *= static_cast<double>(n) / std::max(out.weights.sum(), 1e-12);
    out.at.resize(n, 2);
    out.normal.resize(n, 2);
    out.off_px = found.off_px;
    for (Index i = 0; i < n; ++i) {
      const Vec2 p = camera.Project(out.world.row(i).transpose());
      const Vec2 d = camera.Project(found.targets.row(i).transpose()) - p;
      out.at.row(i) = p.transpose();
      out.normal.row(i) = d.normalized().transpose();
    }
    return out;
  };

  OutlinePose fit;
  fit.camera_from_world = given.camera_from_world;
  Mat6 prior = Mat6::Zero();
  if (options.turn_deg > 0)
    prior.diagonal().head<3>().setConstant(1.0 / std::pow(options.turn_deg * kDegree, 2));
  if (options.shift_mm > 0)
    prior.diagonal().tail<3>().setConstant(1.0 / std::pow(options.shift_mm, 2));
  Vec6 motion = Vec6::Zero();  // from the given pose
  CameraModel camera = given;
  for (int step = 0; step <= kSteps; ++step) {
    const Offsets offsets = compare(camera);
    const Index n = offsets.off_px.size();
    if (n < kLeastPoints) break;
    if (step == 0) fit.points = n;
    const double distance = TrimmedMean(offsets.off_px, offsets.weights);
    if (step == 0) fit.before_px = distance;
    // A pose that loses sight of the outline is not the better for it.
    const bool as_much_seen = static_cast<double>(n) >= kAsMuch * static_cast<double>(fit.points);
    if (step == 0 || (as_much_seen && distance < fit.after_px)) {
      fit.after_px = distance;
      fit.camera_from_world = camera.camera_from_world;
    }
    if (step == kSteps) break;
    const double scale = std::max(kLeastScale_px, 1.5 * distance);
    Mat6 h = prior;
    Vec6 g = -prior * motion;
    for (Index i = 0; i < n; ++i) {
      const double robust =
          std::pow(scale * scale / (scale * scale + std::pow(offsets.off_px[i], 2)), 2);
      const double weight = offsets.weights[i] * robust / (kNoise_px * kNoise_px * kNeighbours);
      Vec6 row;
      for (int k = 0; k < 6; ++k) {
        constexpr double kStep = 1e-3;
        CameraModel moved = camera;
        moved.camera_from_world =
            Moved(given.camera_from_world, motion + kStep * Vec6::Unit(k), center);
        row[k] =
            offsets.normal.row(i).dot(moved.Project(offsets.world.row(i).transpose()).transpose() -
                                      offsets.at.row(i)) /
            kStep;
      }
      h += weight * row * row.transpose();
      g += weight * offsets.off_px[i] * row;
    }
    const Vec6 by = (h + 1e-9 * h.trace() * Mat6::Identity()).ldlt().solve(g);
    motion += by;
    camera.camera_from_world = Moved(given.camera_from_world, motion, center);
    if (by.tail<3>().norm() + by.head<3>().norm() * 50.0 < kDone_mm) break;
  }
  return fit;
}

}  // namespace kerf
