#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "Phantom/PhantomTracks.h"
#include "Support/TestCameras.h"

namespace kerf {
namespace {

/// A triangle seen by a distorting camera.
TEST(Rasterizer, HitsExactlyThePixelsWhoseRaysHit) {
  CameraModel camera = testing::Pinhole(120, 90, 100);
  camera.distortion = {-0.1, 0.02, 1e-3, -1e-3, 0.0};
  SurfaceMesh triangle;
  triangle.points.resize(3, 3);
  triangle.points << -0.5, -0.4, 10.0, 1.3, -0.2, 11.0, 0.1, 1.2, 9.0;
  triangle.triangles.resize(1, 3);
  triangle.triangles << 0, 1, 2;
  VisibilityBuffer seen(camera.width, camera.height);
  Rasterize(triangle, camera, 5, &seen);
  const Vec3 a = triangle.points.row(0), b = triangle.points.row(1), c = triangle.points.row(2);
  int hits = 0, wrong = 0;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Ray ray = camera.RayThrough(Vec2(u, v));
      Mat3 m;
      m << b - a, c - a, -ray.direction;
      const Vec3 solution = m.inverse() * (ray.origin - a);  // weights of b and c, distance
      const bool inside = solution.x() > 0 && solution.y() > 0 && solution.x() + solution.y() < 1;
      const std::size_t at = seen.At(u, v);
      wrong += inside != seen.Hit(at);
      if (!inside || !seen.Hit(at)) continue;
      ++hits;
      EXPECT_EQ(seen.triangle[at], 5);
      // Straight edges between distorted vertices: a hundredth here, for a triangle larger than any
      // of ours.
      EXPECT_NEAR(seen.weight1[at], solution.x(), 0.02);
      EXPECT_NEAR(seen.weight2[at], solution.y(), 0.02);
      EXPECT_NEAR(seen.depth_mm[at], camera.Depth(ray.origin + solution.z() * ray.direction), 0.05);
    }
  EXPECT_GT(hits, 80);
  EXPECT_LE(wrong, 4);
}

TEST(Rasterizer, TheNearerSurfaceWins) {
  const CameraModel camera = testing::Pinhole(20, 20, 20);
  SurfaceMesh surface;
  surface.points.resize(6, 3);
  surface.points << -9, -9, 10, 9, -9, 10, 0, 9, 10, -9, -9, 5, 9, -9, 5, 0, 9, 5;
  surface.triangles.resize(2, 3);
  surface.triangles << 3, 4, 5, 0, 1, 2;
  VisibilityBuffer seen(20, 20);
  Rasterize(surface, camera, 0, &seen);
  EXPECT_EQ(seen.triangle[seen.At(9, 9)], 0);
  EXPECT_FLOAT_EQ(seen.depth_mm[seen.At(9, 9)], 5.0F);
}

class Scene : public ::testing::TestWithParam<PhantomScenario> {
 protected:
  PhantomSetup setup_ = MakePhantomSetup(GetParam(), 1);
  PhantomAnatomy anatomy_ = BuildPhantomAnatomy(setup_);
  PhantomScene scene_{setup_, anatomy_};
  int last_frame_ = setup_.frame_count - 1;  ///< and at 100 the first cut grows
};

TEST_P(Scene, IsTheSameOnEveryRun) {
  const PhantomView a = scene_.Render(100, true), b = scene_.Render(100, true);
  EXPECT_EQ(a.image.data, b.image.data);
  EXPECT_EQ(a.mask.data, b.mask.data);
  PhantomSetup other = setup_;
  other.seed = 2;
  const PhantomScene second(other, anatomy_);
  const PhantomView c = second.Render(100, true);
  EXPECT_NE(a.image.data, c.image.data);
  EXPECT_EQ(a.mask.data, c.mask.data);
}

TEST_P(Scene, ShowsTheOrganWhereItsTruthProjects) {
  const PhantomMotion motion(setup_.motion);
  for (int frame : {0, 100, last_frame_}) {
    const PhantomView view = scene_.Render(frame, false);
    const SurfaceMesh organ = OrganAtFrame(anatomy_, motion, frame).mesh;
    for (Index p = 0; p < organ.points.rows(); p += 7) {
      const Vec2 pixel =
          setup_.camera.Project(setup_.world_from_organ * organ.points.row(p).transpose());
      if (!setup_.camera.InImage(pixel, 2.0)) continue;
      bool found = false;  // a vertex on the outline may miss its nearest pixel centre
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du)
          found = found ||
                  view.mask.data[view.organ.At(static_cast<int>(std::lround(pixel.x())) + du,
                                               static_cast<int>(std::lround(pixel.y())) + dv)] != 0;
      ASSERT_TRUE(found) << "frame " << frame << ", pixel " << pixel.transpose();
    }
  }
}

TEST_P(Scene, StaysInViewAndMarksInstruments) {
  for (int frame : {0, 100, last_frame_}) {
    const PhantomView view = scene_.Render(frame, false);
    int hidden = 0, organ = 0;
    for (int v = 0; v < view.organ.height; ++v)
      for (int u = 0; u < view.organ.width; ++u) {
        const std::uint8_t m = view.mask.data[view.organ.At(u, v)];
        hidden += m == 128;
        organ += m != 0;
        const bool border =
            v == 0 || v + 1 == view.organ.height || u == 0 || u + 1 == view.organ.width;
        ASSERT_FALSE(border && m != 0) << "frame " << frame;
      }
    EXPECT_GT(organ, 15000);
    EXPECT_TRUE(!setup_.has_tool || (hidden > 0) == (frame == 100)) << frame;
  }
}

TEST_P(Scene, HasHighlightsAndTheNoiseOfASensor) {
  const PhantomView a = scene_.Render(0, true), b = scene_.Render(1, true);  // both at rest
  int organ = 0, highlights = 0;
  double sum = 0, square = 0;
  for (std::size_t at = 0; at < a.mask.data.size(); ++at) {
    if (a.mask.data[at] != 255 || b.mask.data[at] != 255) continue;
    ++organ;
    const std::uint8_t* pixel = &a.image.data[3 * at];
    highlights += *std::min_element(pixel, pixel + 3) > 200;
    const double difference = double(a.image.data[3 * at + 1]) - b.image.data[3 * at + 1];
    sum += difference;
    square += difference * difference;
  }
  const double mean = sum / organ, noise = std::sqrt((square / organ - mean * mean) / 2);
  EXPECT_NEAR(mean, 0.0, 0.2);
  EXPECT_GT(noise, 0.7);
  EXPECT_LT(noise, 5.0);
  if (!setup_.is_kidney) return;  // silicone is dull
  EXPECT_GT(highlights, organ / 2000);
  EXPECT_LT(highlights, organ / 20);
}

TEST_P(Scene, FeaturesAreSpreadOverWhatTheCameraSees) {
  const PhantomView first = scene_.Render(0, false);
  const PhantomFeatures features = ChooseFeatures(setup_, anatomy_, first, 300);
  ASSERT_EQ(features.rest.rows(), 300);
  const PhantomTracks rest = TrackFeatures(setup_, features, first, 0);
  for (Index i = 0; i < 300; ++i) {
    EXPECT_EQ(rest.visible[i], 1);
    EXPECT_NE(first.mask.data[first.organ.At(static_cast<int>(std::lround(rest.pixels(i, 0))),
                                             static_cast<int>(std::lround(rest.pixels(i, 1))))],
              0);
  }
  for (Index i = 0; i < 300; ++i)
    for (Index j = 0; j < i; ++j)
      ASSERT_GT((features.rest.row(i) - features.rest.row(j)).norm(), 1.0);
  const PhantomTracks last =
      TrackFeatures(setup_, features, scene_.Render(last_frame_, false), last_frame_);
  EXPECT_GT(std::count(last.visible.begin(), last.visible.end(), 1), 240);
  if (setup_.has_tool) {
    const PhantomTracks during = TrackFeatures(setup_, features, scene_.Render(100, false), 100);
    EXPECT_LT(std::count(during.visible.begin(), during.visible.end(), 1), 300)
        << "the scissors hide some";
  }
}

TEST(PhantomTool, EveryCutHasScissorsWhileItGrowsAndThereIsOnePairAtATime) {
  const PhantomSetup setup = MakePhantomSetup(PhantomScenario::KidneyTwoCuts, 1);
  const PhantomMotion motion(setup.motion);
  const Index one_pair = static_cast<Index>(ToolAtFrame(setup, motion, 90).mesh.points.rows());
  for (int frame = 0; frame < setup.frame_count; ++frame) {
    const PhantomTool tool = ToolAtFrame(setup, motion, frame);
    EXPECT_LE(tool.mesh.points.rows(), one_pair) << frame;
    for (int k = 0; k < motion.CutCount(); ++k) {
      const PhantomCutParameters& cut = setup.motion.cuts[k];
      if (frame < cut.start_frame || frame > cut.end_frame) continue;
      EXPECT_EQ(tool.mesh.points.rows(), one_pair) << frame;
      const Points line = CutLine(setup, motion, k, std::max(0.5, motion.TipDepth_mm(frame, k)));
      const Vec3 tip =
          setup.world_from_organ * motion.Position(line.row(line.rows() - 1), k, frame);
      const Eigen::VectorXd distance =
          (tool.mesh.points.rowwise() - tip.transpose()).rowwise().norm();
      EXPECT_LT(distance.minCoeff(), 5.0) << "at the tip of its own cut, frame " << frame;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Phantom, Scene,
                         ::testing::Values(PhantomScenario::KidneyCut, PhantomScenario::BandCut,
                                           PhantomScenario::KidneyTwoCuts,
                                           PhantomScenario::BandTwoCuts),
                         [](const auto& info) {
                           std::string name = ToString(info.param);
                           name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
                           return name;
                         });

}  // namespace
}  // namespace kerf
