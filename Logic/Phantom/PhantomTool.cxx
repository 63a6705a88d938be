#include "Phantom/PhantomTool.h"

#include <algorithm>
#include <cmath>

#include "Phantom/PhantomAnatomy.h"

namespace kerf {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kLeave_frames = 20.0;  ///< that the scissors take to go after a cut

void Append(const SurfaceMesh& part, bool metal, PhantomTool* tool) {
  const Index base = static_cast<Index>(tool->mesh.points.rows());
  tool->mesh.points.conservativeResize(base + part.points.rows(), 3);
  tool->mesh.points.bottomRows(part.points.rows()) = part.points;
  const Triangles moved = part.triangles.array() + base;
  tool->mesh.triangles.conservativeResize(tool->mesh.triangles.rows() + moved.rows(), 3);
  tool->mesh.triangles.bottomRows(moved.rows()) = moved;
  tool->is_metal.insert(tool->is_metal.end(), part.points.rows(), metal ? 1 : 0);
}

struct Ring {
  Vec3 centre;
  double width, height;  ///< half axes along `side` and `up`
};

/// A tube of elliptic rings, closed at both ends.
SurfaceMesh Tube(const std::vector<Ring>& rings, const Vec3& side, const Vec3& up) {
  const int around = 24, n = static_cast<int>(rings.size());
  SurfaceMesh mesh;
  mesh.points.resize(n * around + 2, 3);
  for (int r = 0; r < n; ++r)
    for (int i = 0; i < around; ++i) {
      const double angle = 2.0 * kPi * i / around;
      mesh.points.row(r * around + i) = (rings[r].centre + rings[r].width * std::cos(angle) * side +
                                         rings[r].height * std::sin(angle) * up)
                                            .transpose();
    }
  mesh.points.row(n * around) = rings.front().centre.transpose();
  mesh.points.row(n * around + 1) = rings.back().centre.transpose();
  mesh.triangles.resize(2 * around * n, 3);
  Index t = 0;
  for (int i = 0; i < around; ++i) {
    const int j = (i + 1) % around;
    for (int r = 0; r + 1 < n; ++r) {
      const Index a = r * around + i, b = r * around + j, c = a + around, d = b + around;
      mesh.triangles.row(t++) << a, b, d;
      mesh.triangles.row(t++) << a, d, c;
    }
    mesh.triangles.row(t++) << n * around, j, i;
    mesh.triangles.row(t++) << n * around + 1, (n - 1) * around + i, (n - 1) * around + j;
  }
  return mesh;
}

std::vector<Ring> Straight(const Vec3& from, const Vec3& to, double radius_from, double radius_to,
                           double step_mm) {
  std::vector<Ring> rings;
  const int n = std::max(1, static_cast<int>((to - from).norm() / step_mm));
  for (int i = 0; i <= n; ++i) {
    const double t = double(i) / n, radius = radius_from + t * (radius_to - radius_from);
    rings.push_back({from + t * (to - from), radius, radius});
  }
  return rings;
}

/// Curved scissors, 5 mm shaft. @param tip where the blades meet; @param back unit vector towards
/// the handle
void AddScissors(const Vec3& tip, const Vec3& back, const Vec3& side, double opening_deg,
                 PhantomTool* tool) {
  const Vec3 up = back.cross(side).normalized();
  const Vec3 pivot = tip + 15.0 * back;
  for (int blade = -1; blade <= 1; blade += 2) {
    std::vector<Ring> rings;
    const double half = 0.5 * opening_deg * kPi / 180.0 * blade;
    const Vec3 forward = -std::cos(half) * back + std::sin(half) * side;
    for (int i = 0; i <= 14; ++i) {
      const double t = i / 14.0;
      // Slim towards the point, with the slight curve that such blades have.
      rings.push_back({pivot + 15.0 * t * forward + 0.8 * t * t * up + 0.35 * blade * side,
                       0.2 + 1.25 * (1.0 - t * t), 0.15 + 0.75 * (1.0 - 0.8 * t)});
    }
    Append(Tube(rings, side, up), true, tool);
  }
  Append(Tube(Straight(pivot - 1.5 * back, pivot + 7.0 * back, 1.9, 2.35, 2.0), side, up), true,
         tool);
  Append(Tube(Straight(pivot + 7.0 * back, pivot + 170.0 * back, 2.55, 2.55, 4.0), side, up), false,
         tool);
}

Vec3 LipMiddle(const PhantomSetup& setup, const PhantomMotion& motion, int cut, double frame) {
  const Points line = CutLine(setup, motion, cut, std::max(motion.TipDepth_mm(frame, cut), 0.5));
  const Vec3 rest = line.row(line.rows() - 1);
  return 0.5 * (motion.Position(rest, cut, frame) + motion.Position(rest, cut + 1, frame));
}

double Ease(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

void AddGrips(const PhantomSetup& setup, const PhantomMotion& motion, double frame,
              PhantomTool* tool) {
  const Vec3 half = 0.5 * setup.band_size_mm;
  for (int end = -1; end <= 1; end += 2) {
    const double x = motion.Position({end * half.x(), 0, 0}, 0, frame).x() - 2.0 * end;
    std::vector<Ring> rings;
    const double r = std::sqrt(2.0);
    for (int i = 0; i <= 10; ++i)
      rings.push_back({Vec3(x + end * 1.6 * i, 0, 0), r * (half.y() + 5.0), r * (half.z() + 3.0)});
    // Four-sided: every sixth point of the ring's 24.
    SurfaceMesh round = Tube(rings, Vec3::UnitY(), Vec3::UnitZ());
    for (Index p = 0; p < round.points.rows(); ++p) {
      Vec3 q = round.points.row(p);
      q.y() = std::clamp(q.y(), -half.y() - 5.0, half.y() + 5.0);
      q.z() = std::clamp(q.z(), -half.z() - 3.0, half.z() + 3.0);
      round.points.row(p) = q.transpose();
    }
    Append(round, false, tool);
  }
  tool->mesh.points = ToWorld(tool->mesh.points, setup.world_from_organ);
}

/// The scissors that make one cut: they come, follow its tip, and go.
/// @param free_frame when the scissors of the cut before are gone
void AddCuttingScissors(const PhantomSetup& setup, const PhantomMotion& motion, int cut,
                        double free_frame, double frame, PhantomTool* tool) {
  const double start = motion.Parameters().cuts[cut].start_frame,
               end = motion.Parameters().cuts[cut].end_frame;
  const double come = std::max(start - 38.0, free_frame);
  const double arrive = Ease((frame - come) / (start - 4.0 - come));
  const double leave = Ease((frame - (end + 3.0)) / kLeave_frames);
  if (arrive <= 0.0 || leave >= 1.0) return;
  const Mat3 world_from_camera = setup.camera.camera_from_world.linear().transpose();
  // From below, a little to the right: along the cut, so that the shaft hides little of the organ.
  const Vec3 back = (world_from_camera * Vec3(0.30, 0.80, -0.45)).normalized();
  const Vec3 view = setup.camera.ViewDirection();
  const Vec3 side = back.cross(view).normalized();
  Vec3 tip = setup.world_from_organ * LipMiddle(setup, motion, cut, frame);
  tip -= 1.8 * view;  // the blades embrace the edge rather than sink in
  const double away = (1.0 - arrive) + leave;
  tip += 105.0 * away * back + 12.0 * std::sin(kPi * std::min(1.0, away)) * -view;
  const bool cutting = frame >= start && frame <= end;
  const double opening =
      cutting ? 15.0 + 13.0 * std::cos(2.0 * kPi * (frame - start) / 9.0) : 20.0 - 14.0 * leave;
  AddScissors(tip, back, side, opening, tool);
}

}  // namespace

PhantomTool ToolAtFrame(const PhantomSetup& setup, const PhantomMotion& motion, double frame) {
  PhantomTool tool;
  if (!setup.is_kidney) {
    AddGrips(setup, motion, frame, &tool);
    return tool;
  }
  double free_frame = 0.0;
  for (int cut = 0; setup.has_tool && cut < motion.CutCount(); ++cut) {
    AddCuttingScissors(setup, motion, cut, free_frame, frame, &tool);
    free_frame = motion.Parameters().cuts[cut].end_frame + 3.0 + kLeave_frames;
  }
  return tool;
}

}  // namespace kerf
