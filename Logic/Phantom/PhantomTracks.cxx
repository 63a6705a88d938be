#include "Phantom/PhantomTracks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "Phantom/Noise.h"

namespace kerf {
namespace {

/// Greedy farthest-point order of `candidates`, from the one nearest to their mean.
std::vector<Index> FarthestPoints(const Points& candidates, int count) {
  const Eigen::RowVector3d mean = candidates.colwise().mean();
  Eigen::Index next = 0;
  (candidates.rowwise() - mean).rowwise().squaredNorm().minCoeff(&next);
  Eigen::VectorXd distance =
      Eigen::VectorXd::Constant(candidates.rows(), std::numeric_limits<double>::max());
  std::vector<Index> chosen;
  while (static_cast<int>(chosen.size()) < std::min<Eigen::Index>(count, candidates.rows())) {
    chosen.push_back(static_cast<Index>(next));
    distance =
        distance.cwiseMin((candidates.rowwise() - candidates.row(next)).rowwise().squaredNorm());
    distance.maxCoeff(&next);
  }
  return chosen;
}

}  // namespace

PhantomFeatures ChooseFeatures(const PhantomSetup& setup, const PhantomAnatomy& anatomy,
                               const PhantomView& first, int count) {
  const PhantomMotion motion(setup.motion);
  const SurfaceMesh rest = OrganAtFrame(anatomy, motion, 0).mesh;
  const Vec3 eye = setup.world_from_organ.inverse() * setup.camera.Center();
  std::vector<Vec3> found;
  const int step = 7;
  for (int v = step; v + step < first.organ.height; v += step)
    for (int u = step; u + step < first.organ.width; u += step) {
      // Jittered, so that the points do not line up with the pixel grid.
      const std::uint32_t h =
          Hash(static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(v), 77, setup.seed);
      const std::size_t at =
          first.organ.At(u + static_cast<int>(h % 7U) - 3, v + static_cast<int>(h / 7U % 7U) - 3);
      if (!first.organ.Hit(at) || first.tool[at]) continue;
      const Index t = first.organ.triangle[at];
      const Vec3 a = rest.points.row(rest.triangles(t, 0)),
                 b = rest.points.row(rest.triangles(t, 1)),
                 c = rest.points.row(rest.triangles(t, 2));
      const Vec3 p =
          a + double(first.organ.weight1[at]) * (b - a) + double(first.organ.weight2[at]) * (c - a);
      const Vec3 normal = (b - a).cross(c - a).normalized();
      if (normal.dot((eye - p).normalized()) < 0.3) continue;
      bool on_sheet = false;
      for (int cut = 0; cut < motion.CutCount(); ++cut)
        on_sheet = on_sheet || std::abs(motion.SheetDistance_mm(p, cut)) < 0.4;
      if (!on_sheet) found.push_back(p);
    }
  Points candidates(static_cast<Eigen::Index>(found.size()), 3);
  for (std::size_t i = 0; i < found.size(); ++i) candidates.row(i) = found[i].transpose();
  const std::vector<Index> chosen = FarthestPoints(candidates, count);
  PhantomFeatures features;
  features.rest.resize(static_cast<Eigen::Index>(chosen.size()), 3);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    features.rest.row(i) = candidates.row(chosen[i]);
    features.region.push_back(motion.Region(features.rest.row(i)));
  }
  return features;
}

PhantomTracks TrackFeatures(const PhantomSetup& setup, const PhantomFeatures& features,
                            const PhantomView& view, int frame) {
  const PhantomMotion motion(setup.motion);
  PhantomTracks tracks;
  tracks.world.resize(features.rest.rows(), 3);
  tracks.pixels.resize(features.rest.rows(), 2);
  for (Eigen::Index i = 0; i < features.rest.rows(); ++i) {
    const Vec3 world =
        setup.world_from_organ * motion.Position(features.rest.row(i), features.region[i], frame);
    const Vec2 pixel = setup.camera.Project(world);
    tracks.world.row(i) = world.transpose();
    tracks.pixels.row(i) = pixel.transpose();
    bool visible = setup.camera.InImage(pixel, 1.0);
    if (visible) {
      const int u = static_cast<int>(std::lround(pixel.x())),
                v = static_cast<int>(std::lround(pixel.y()));
      // Seen if any neighbouring pixel shows a surface at this depth: at the outline the nearest
      // one may miss.
      bool surface = false;
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du) {
          const std::size_t at = view.organ.At(u + du, v + dv);
          surface = surface || (view.organ.Hit(at) &&
                                view.organ.depth_mm[at] > setup.camera.Depth(world) - 0.5);
        }
      visible = surface && view.tool[view.organ.At(u, v)] == 0;
    }
    tracks.visible.push_back(visible ? 1 : 0);
  }
  return tracks;
}

std::vector<Index> ChooseLandmarks(const PhantomFeatures& features, int count) {
  return FarthestPoints(features.rest, count);
}

}  // namespace kerf
