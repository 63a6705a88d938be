#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/OpenCv/LandmarkRegistration.h"
#include "Core/Errors.h"
#include "Support/CasesFolder.h"
#include "Support/Draws.h"
#include "Support/TestCameras.h"

using namespace kerf;
using kerf::testing::Laparoscope;

namespace {

struct Scene {
  CameraModel camera = Laparoscope();
  Points world;
  Pixels pixels;
};

/// `count` points on a kidney-sized ellipsoid's near side, seen from 140 mm.
Scene MakeScene(int seed, int count, double pixel_noise_px, double point_noise_mm,
                double thickness_mm = 25) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> side(-1, 1);
  std::normal_distribution<double> normal;
  Scene scene;
  const Vec3 axis = kerf::testing::DrawVec3([&] { return side(random); }).normalized();
  const double angle = 3 * side(random);
  const Vec2 aside = kerf::testing::DrawVec2([&] { return 5 * side(random); });
  scene.camera.camera_from_world = Eigen::Translation3d(aside.x(), aside.y(), 140) *
                                   Eigen::AngleAxisd(angle, axis) *
                                   Eigen::Translation3d(-80, 20, -300);
  scene.world.resize(count, 3);
  scene.pixels.resize(count, 2);
  for (int i = 0; i < count; ++i) {
    const double x = 0.8 * side(random), y = 0.8 * side(random);
    const Vec3 in_camera(50 * x, 27 * y,
                         -thickness_mm * std::sqrt(std::max(0.0, 1 - x * x - y * y)));
    const Vec3 point = scene.camera.camera_from_world.inverse() * (in_camera + Vec3(0, 0, 140));
    scene.pixels.row(i) = scene.camera.Project(point) +
                          pixel_noise_px * kerf::testing::DrawVec2([&] { return normal(random); });
    scene.world.row(i) =
        point + point_noise_mm * kerf::testing::DrawVec3([&] { return normal(random); });
  }
  return scene;
}

double Degrees(const CameraModel& a, const CameraModel& b) {
  return Eigen::AngleAxisd(
             Mat3(a.camera_from_world.linear() * b.camera_from_world.linear().transpose()))
             .angle() *
         180 / M_PI;
}
double MeanDistance_mm(const CameraModel& a, const CameraModel& b, const Points& world) {
  double sum = 0;
  for (Index i = 0; i < world.rows(); ++i) {
    const Vec3 p = world.row(i);
    sum += (a.camera_from_world * p - b.camera_from_world * p).norm();
  }
  return sum / static_cast<double>(world.rows());
}

TEST(Landmarks, ExactPairsGiveTheExactPose) {
  for (int seed = 0; seed < 20; ++seed) {
    const Scene scene = MakeScene(seed, 8, 0, 0);
    const LandmarkResult result = RegisterLandmarks(scene.world, scene.pixels, Laparoscope());
    EXPECT_LT(Degrees(result.camera, scene.camera), 1e-4) << seed;
    EXPECT_LT(MeanDistance_mm(result.camera, scene.camera, scene.world), 1e-4) << seed;
    EXPECT_LT(result.rms_px, 1e-4);
    EXPECT_TRUE(result.outliers.empty());
    EXPECT_EQ(result.camera.fx, scene.camera.fx);
  }
}

TEST(Landmarks, NoiseOfTheStudiesStaysSmall) {
  double sum_mm = 0;
  for (int seed = 0; seed < 30; ++seed) {
    const Scene scene = MakeScene(100 + seed, 8, 1.0, 0.5);
    const LandmarkResult result = RegisterLandmarks(scene.world, scene.pixels, Laparoscope());
    sum_mm += MeanDistance_mm(result.camera, scene.camera, scene.world) / 30;
    EXPECT_LT(result.rms_px, 8);
  }
  EXPECT_LT(sum_mm, 2.0);
}

TEST(Landmarks, OutliersAreNamedAndLeftOut) {
  int named = 0;
  for (int seed = 0; seed < 30; ++seed) {
    Scene scene = MakeScene(200 + seed, 9, 0.7, 0.2);
    const Index bad = seed % 9;
    scene.pixels(bad, 0) += seed % 2 ? 90 : -80;
    const LandmarkResult result = RegisterLandmarks(scene.world, scene.pixels, Laparoscope());
    if (!result.outliers.empty() && result.outliers[0] == bad) ++named;
    EXPECT_LT(MeanDistance_mm(result.camera, scene.camera, scene.world), 6.0) << seed;
  }
  EXPECT_GE(named, 29);
}

TEST(Landmarks, TwoSwappedLandmarksAreFound) {
  Scene scene = MakeScene(31, 10, 0.5, 0.2);
  const Eigen::RowVector2d first = scene.pixels.row(2);
  scene.pixels.row(2) = scene.pixels.row(7);
  scene.pixels.row(7) = first;
  const LandmarkResult result = RegisterLandmarks(scene.world, scene.pixels, Laparoscope());
  std::vector<Index> outliers = result.outliers;
  std::sort(outliers.begin(), outliers.end());
  EXPECT_EQ(outliers, (std::vector<Index>{2, 7}));
  EXPECT_FALSE(result.warning.empty());
}

TEST(Landmarks, ResidualsAreDistances) {
  const Scene scene = MakeScene(5, 8, 1.5, 0.5);
  const LandmarkResult result = RegisterLandmarks(scene.world, scene.pixels, Laparoscope());
  for (Index i = 0; i < 8; ++i) {
    const Vec2 projected = result.camera.Project(scene.world.row(i));
    const double px = (projected - scene.pixels.row(i).transpose()).norm();
    EXPECT_NEAR(result.residual_px[i], px, 1e-9);
    const double depth = result.camera.Depth(scene.world.row(i));
    EXPECT_NEAR(result.residual_mm[i], px * depth / 905.9, 0.01 * (1 + px));
  }
}

TEST(Landmarks, FlatDistantScenesAreAmbiguousAndDeepOnesAreNot) {
  int flagged = 0, wrongly = 0;
  for (int seed = 0; seed < 20; ++seed) {
    // A small flat patch seen nearly frontally with noise: its mirror pose fits as well.
    Scene flat = MakeScene(300 + seed, 6, 1.5, 0.0, 0.0);
    CameraModel far = flat.camera;
    far.camera_from_world = Eigen::Translation3d(0, 0, 500) *
                            Eigen::AngleAxisd(0.25, Vec3::UnitY()) *
                            Eigen::Translation3d(0, 0, -140) * flat.camera.camera_from_world;
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (Index i = 0; i < 6; ++i)
      flat.pixels.row(i) = far.Project(flat.world.row(i)) +
                           1.5 * kerf::testing::DrawVec2([&] { return normal(random); });
    if (RegisterLandmarks(flat.world, flat.pixels, Laparoscope()).ambiguous) ++flagged;
    const Scene deep = MakeScene(400 + seed, 10, 0.5, 0.1, 40);
    if (RegisterLandmarks(deep.world, deep.pixels, Laparoscope()).ambiguous) ++wrongly;
  }
  EXPECT_GE(flagged, 12);
  EXPECT_EQ(wrongly, 0);
}

TEST(Landmarks, SameInputSameBits) {
  const Scene scene = MakeScene(8, 20, 1, 0.5);
  const LandmarkResult a = RegisterLandmarks(scene.world, scene.pixels, Laparoscope());
  const LandmarkResult b = RegisterLandmarks(scene.world, scene.pixels, Laparoscope());
  EXPECT_TRUE(a.camera.camera_from_world.matrix() == b.camera.camera_from_world.matrix());
}

TEST(Landmarks, BadInputIsRefusedByName) {
  const Scene scene = MakeScene(3, 8, 0, 0);
  const auto expect = [](const Points& world, const Pixels& pixels, const std::string& word) {
    try {
      RegisterLandmarks(world, pixels, Laparoscope(), "landmarks.csv");
      ADD_FAILURE() << "accepted: " << word;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("landmarks.csv"), std::string::npos);
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  expect(scene.world.topRows(3), scene.pixels.topRows(3), "4");
  expect(scene.world, scene.pixels.topRows(7), "7");
  Points world = scene.world;
  world(5, 1) = std::numeric_limits<double>::quiet_NaN();
  expect(world, scene.pixels, "landmark 5");
  Pixels pixels = scene.pixels;
  pixels(2, 0) = std::numeric_limits<double>::infinity();
  expect(scene.world, pixels, "landmark 2");
  world = scene.world;
  world.row(6) = world.row(1);
  expect(world, scene.pixels, "landmark 6");
  for (Index i = 0; i < 8; ++i) world.row(i) = Vec3(10.0 * i, 5.0 * i, 300 - 2.0 * i);
  expect(world, scene.pixels, "line");
}

/// The studies' landmarks (1 px and 0.5 mm of noise) against the pose of the video.
TEST(Landmarks, StudiesAgainstTruth) {
  const std::filesystem::path cases = kerf::testing::CasesFolder();
  if (!std::filesystem::exists(cases / "kidney-1"))
    GTEST_SKIP() << "no studies at " << cases << " (set KERF_CASES)";
  for (const std::string study : {"kidney-1", "kidney-2", "kidney-nocut", "liver-1"}) {
    const CameraModel truth = ReadCameraFile((cases / study / "truth/camera_true.yml").string());
    std::ifstream in(cases / study / "landmarks.csv");
    std::string line;
    std::getline(in, line);
    std::vector<std::array<double, 5>> rows;
    while (std::getline(in, line)) {
      int id = 0;
      std::array<double, 5> r{};
      if (std::sscanf(line.c_str(), "%d,%lf,%lf,%lf,%lf,%lf", &id, &r[0], &r[1], &r[2], &r[3],
                      &r[4]) == 6)
        rows.push_back(r);
    }
    Points world(static_cast<Index>(rows.size()), 3);
    Pixels pixels(static_cast<Index>(rows.size()), 2);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      world.row(static_cast<Index>(i)) << -rows[i][0], -rows[i][1], rows[i][2];  // RAS to LPS
      pixels.row(static_cast<Index>(i)) << rows[i][3], rows[i][4];
    }
    const LandmarkResult result = RegisterLandmarks(world, pixels, truth);
    EXPECT_LT(MeanDistance_mm(result.camera, truth, world), 1.5) << study;
    EXPECT_LT(Degrees(result.camera, truth), 2.0) << study;
    EXPECT_TRUE(result.outliers.empty()) << study;
    EXPECT_FALSE(result.ambiguous) << study;
  }
}

}  // namespace
