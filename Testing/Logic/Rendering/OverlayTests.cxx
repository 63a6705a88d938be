// What the overlay shows, hides and leaves alone.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "Adapters/Rendering/CoverageMap.h"
#include "Adapters/Rendering/ImageEncoding.h"
#include "Adapters/Rendering/OverlayCompositor.h"
#include "Adapters/Rendering/OverlayRenderer.h"
#include "Adapters/Rendering/VirtualDisplay.h"
#include "Core/Errors.h"
#include "OverlayScenes.h"
#include "Support/ImageSimilarity.h"

namespace kerf {
namespace {

using testing::Bind;
using testing::MakePhantomScene;
using testing::PhantomScene;

constexpr int kWidth = 480, kHeight = 270;

Vec3 At(const Image& image, const Vec2& pixel) {  // RGB
  const std::size_t i =
      3 * (std::size_t(std::lround(pixel.y())) * image.width + std::size_t(std::lround(pixel.x())));
  return Vec3(image.data[i + 2], image.data[i + 1], image.data[i]);
}

double Difference(const Image& a, const Image& b, const Vec2& pixel) {
  return (At(a, pixel) - At(b, pixel)).norm();
}

class Overlay : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string why;
    if (!RenderingAvailable(&why)) GTEST_SKIP() << why;
    phantom = MakePhantomScene(kWidth, kHeight);
    Bind(&phantom);
    plain.show_status = plain.show_legend = plain.show_notice = false;
  }
  const Image& Raw() const { return *phantom.scene.frame.image; }
  PhantomScene phantom;
  OverlayOptions plain;  ///< no text, for tests that look at pixels
};

TEST_F(Overlay, TumourIsWhereItProjectsAndReadsOnTissue) {
  OverlayRenderer renderer(phantom.lens, plain);
  const Image picture = renderer.Render(phantom.scene);
  const Vec3 color = At(picture, phantom.lens.Project({-26, 4, -9}));
  EXPECT_GT(color.y(), color.x() * 0.9) << color.transpose();  // greener than red tissue ever is
  EXPECT_GT(color.y(), color.z() + 80) << color.transpose();
}

TEST_F(Overlay, OrganOutlineFollowsTheSilhouette) {
  OverlayRenderer renderer(phantom.lens, plain);
  const Image picture = renderer.Render(phantom.scene);
  // Rays that touch the ellipsoid on the left: scan along the row of the centre.
  int first = -1;
  const double v = phantom.lens.Project({-40, 0, 0}).y();
  for (int u = 0; u < kWidth && first < 0; ++u)
    if (At(picture, {double(u), v}).z() > 180) first = u;
  double silhouette = kWidth;
  for (Index i = 0; i < phantom.organ.points.rows(); ++i)
    silhouette =
        std::min(silhouette, phantom.lens.Project(phantom.organ.points.row(i).transpose()).x());
  EXPECT_NEAR(first, silhouette, 2.5);
}

TEST_F(Overlay, OutsideTheOrganTheVideoIsUntouched) {
  OverlayRenderer renderer(phantom.lens, plain);
  const Image picture = renderer.Render(phantom.scene);
  for (const Vec2& pixel : {Vec2(5, 5), Vec2(240, 12), Vec2(20, 255)})
    EXPECT_EQ(Difference(picture, Raw(), pixel), 0) << pixel.transpose();
}

TEST_F(Overlay, GateOffShowsTheVideoAndTheReasonAlone) {
  phantom.scene.status.gate = OverlayStatus::Gate::Off;
  phantom.scene.status.reason = "tracking lost";
  const Image off = OverlayRenderer(phantom.lens, plain).Render(phantom.scene);
  for (const Vec3& p : {Vec3(-26, 4, -9), Vec3(4, -7, 2), Vec3(-48, 0, 0), Vec3(0, 10, -10)})
    EXPECT_EQ(Difference(off, Raw(), phantom.lens.Project(p)), 0) << p.transpose();
  // Without status the reason is shown all the same: the overlay never goes silently.
  double changed = 0;
  for (int u = 0; u < 200; ++u)
    for (int y = 0; y < 30; ++y) changed += Difference(off, Raw(), Vec2(u, y)) > 30;
  EXPECT_GT(changed, 500);
}

TEST_F(Overlay, AmberIsSeenAtTheEdgeOfThePictureAndGreenIsNot) {
  const Image green = OverlayRenderer(phantom.lens, {}).Render(phantom.scene);
  phantom.scene.status.gate = OverlayStatus::Gate::Amber;
  phantom.scene.status.reason = "few features";
  const Image amber = OverlayRenderer(phantom.lens, {}).Render(phantom.scene);
  EXPECT_EQ(Difference(green, Raw(), Vec2(0, 130)), 0);
  EXPECT_GT(Difference(amber, Raw(), Vec2(0, 130)), 60);
}

TEST_F(Overlay, InstrumentsStayInFront) {
  OverlayRenderer renderer(phantom.lens, plain);
  const Image with = renderer.Render(phantom.scene);
  phantom.scene.instruments = nullptr;
  const Image without = renderer.Render(phantom.scene);
  int inside = 0, covered = 0;
  for (int y = 2; y + 2 < kHeight; ++y)
    for (int x = 2; x + 2 < kWidth; ++x) {
      bool deep = true;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          deep = deep && phantom.instruments.data[std::size_t(y + dy) * kWidth + x + dx];
      if (!deep) continue;
      ++inside;
      EXPECT_EQ(Difference(with, Raw(), Vec2(x, y)), 0);
      covered += Difference(without, Raw(), Vec2(x, y)) > 10;
    }
  EXPECT_GT(inside, 500);
  EXPECT_GT(covered, 50) << "the instrument did not cross the overlay: the test shows nothing";
}

TEST_F(Overlay, CutLineLiesWhereTheLensPutsIt) {
  OverlayLine line;
  line.current.resize(2, 3);
  line.current << -30, -10, -21, 30, -12, -21;
  phantom.scene.lines = {line};
  phantom.scene.instruments = nullptr;
  OverlayRenderer renderer(phantom.lens, plain);
  const Image picture = renderer.Render(phantom.scene);
  for (double t = 0.02; t < 1; t += 0.06) {
    const Vec3 p = (1 - t) * line.current.row(0).transpose() + t * line.current.row(1).transpose();
    const Vec3 color = At(picture, phantom.lens.Project(p));
    EXPECT_GT(color.x(), 200) << t;
    EXPECT_GT(color.y(), 190) << t;
  }
}

TEST_F(Overlay, AProposedCutIsDashed) {
  OverlayLine line;
  line.kind = OverlayLine::Kind::Proposed;
  line.current.resize(2, 3);
  line.current << -30, -10, -21, 30, -10, -21;
  OverlayScene scene;
  scene.frame = phantom.scene.frame;
  scene.lines = {line};
  const Image picture = OverlayRenderer(phantom.lens, plain).Render(scene);
  int drawn = 0, gap = 0;
  for (double t = 0; t <= 1; t += 0.01) {
    const Vec3 p = (1 - t) * line.current.row(0).transpose() + t * line.current.row(1).transpose();
    (At(picture, phantom.lens.Project(p)).y() > 180 ? drawn : gap)++;
  }
  EXPECT_GT(drawn, 30);
  EXPECT_GT(gap, 30);
}

TEST_F(Overlay, CutFacesAreMarked) {
  OverlayRenderer renderer(phantom.lens, plain);
  const Image with = renderer.Render(phantom.scene);
  phantom.scene.organ_cut_face.clear();
  const Image without = renderer.Render(phantom.scene);
  int marked = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const Vec3 a = At(with, Vec2(x, y)), b = At(without, Vec2(x, y));
      marked += a.x() > b.x() + 30 && a.x() > a.z() + 60;
    }
  EXPECT_GT(marked, 200);
}

TEST_F(Overlay, NearerIsBrighter) {
  const Vec2 left(160, 135), right(320, 135);
  const SurfaceMesh near = testing::Sphere(phantom.lens.PointAtDepth(left, 135), Vec3::Constant(5)),
                    far = testing::Sphere(phantom.lens.PointAtDepth(right, 165), Vec3::Constant(5));
  OverlayScene scene;
  scene.structures = {{OverlayStructure::Kind::Internal, &near},
                      {OverlayStructure::Kind::Internal, &far}};
  OverlayRenderer renderer(phantom.lens, plain);
  const Image picture = renderer.Render(scene);
  EXPECT_GT(At(picture, left).sum(), At(picture, right).sum() + 50);
  plain.depth_cue = false;
  renderer.SetOptions(plain);
  const Image flat = renderer.Render(scene);
  EXPECT_NEAR(At(flat, left).sum(), At(flat, right).sum(), 15);
}

TEST_F(Overlay, SeeThroughWindowDarkensTissueInsideAloneAndFollowsItsCentre) {
  plain.preset = OverlayPreset::SeeThrough;
  plain.window_px = phantom.lens.Project({20, 12, -15});
  plain.window_radius_px = 30;
  phantom.scene.instruments = nullptr;
  const Image picture = OverlayRenderer(phantom.lens, plain).Render(phantom.scene);
  const Vec2 inside = phantom.lens.Project({26, 12, -15}),
             outside = phantom.lens.Project({-10, -15, -13});
  EXPECT_LT(At(picture, inside).sum(), 0.7 * At(Raw(), inside).sum());
  EXPECT_EQ(Difference(picture, Raw(), outside), 0);
}

TEST_F(Overlay, TheSameSceneGivesTheSameBytes) {
  OverlayRenderer first(phantom.lens, {});
  const Image a = first.Render(phantom.scene);
  SurfaceMesh other = phantom.organ;
  other.points *= 0.5;
  OverlayScene between = phantom.scene;
  between.organ = &other;
  first.Render(between);
  EXPECT_EQ(first.Render(phantom.scene).data, a.data) << "it remembers the frame before";
  EXPECT_EQ(OverlayRenderer(phantom.lens, {}).Render(phantom.scene).data, a.data);
}

TEST_F(Overlay, ANewTopologyIsDrawnAtOnce) {
  OverlayRenderer renderer(phantom.lens, plain);
  renderer.Render(phantom.scene);
  const SurfaceMesh ball = testing::Sphere({0, 0, 0}, Vec3::Constant(8));
  OverlayScene scene;
  scene.frame = phantom.scene.frame;
  scene.organ = &ball;
  EXPECT_EQ(renderer.Render(scene).data, OverlayRenderer(phantom.lens, plain).Render(scene).data);
}

TEST_F(Overlay, AnotherPoseIsAsGoodAsANewRenderer) {
  OverlayRenderer renderer(phantom.lens, plain);
  renderer.Render(phantom.scene);
  CameraModel moved = phantom.lens;
  moved.camera_from_world.translation() += Vec3(5, -3, 12);
  renderer.SetCamera(moved);
  EXPECT_EQ(renderer.Render(phantom.scene).data,
            OverlayRenderer(moved, plain).Render(phantom.scene).data);
  renderer.SetCamera(testing::PlainLens(320, 200));
  OverlayScene empty;
  EXPECT_EQ(renderer.Render(empty).width, 320);
}

TEST_F(Overlay, AMarginBelowTheAlarmIsRed) {
  const auto reddest = [&](double margin) {
    OverlayScene scene;
    scene.status.margin_mm = margin;
    scene.status.margin_alarm_mm = 5;
    OverlayOptions options;
    const Image picture = OverlayRenderer(phantom.lens, options).Render(scene);
    double most = 0;
    for (int y = 0; y < 60; ++y)
      for (int x = kWidth / 2; x < kWidth; ++x)
        most = std::max(most, At(picture, Vec2(x, y)).x() - At(picture, Vec2(x, y)).z());
    return most;
  };
  EXPECT_GT(reddest(3.0), 100);
  EXPECT_LT(reddest(8.0), 30);
}

TEST_F(Overlay, ASmallBoundHugsTheTumourAndLeavesItsInsideAlone) {
  phantom.scene.status.tumour_u95_mm = std::numeric_limits<double>::quiet_NaN();
  const Image without = OverlayRenderer(phantom.lens, plain).Render(phantom.scene);
  phantom.scene.status.tumour_u95_mm = 0.05;
  const Image with = OverlayRenderer(phantom.lens, plain).Render(phantom.scene);
  for (const OverlayStructure& s : phantom.scene.structures) {
    if (s.kind != OverlayStructure::Kind::Tumour) continue;
    const Vec2 middle = phantom.lens.Project(s.current->points.colwise().mean().transpose());
    for (int d = -4; d <= 4; ++d)
      EXPECT_EQ(At(with, middle + Vec2(d, 0)), At(without, middle + Vec2(d, 0))) << d;
  }
  EXPECT_NE(with.data, without.data) << "the ring is there";
}

TEST_F(Overlay, ThePlannedMarginIsARingAroundTheTumour) {
  const SurfaceMesh* tumour = nullptr;
  for (const OverlayStructure& s : phantom.scene.structures)
    if (s.kind == OverlayStructure::Kind::Tumour) tumour = s.current;
  ASSERT_TRUE(tumour);
  phantom.scene.status.tumour_u95_mm = std::numeric_limits<double>::quiet_NaN();
  const Image without = OverlayRenderer(phantom.lens, plain).Render(phantom.scene);
  const Vec3 middle = tumour->points.colwise().mean().transpose();
  const Vec2 at = phantom.lens.Project(middle);
  /// How far from the tumour's middle the ring is, to the right and upwards, px.
  const auto ring_px = [&](double margin_mm) {
    phantom.scene.status.planned_margin_mm = margin_mm;
    const Image with = OverlayRenderer(phantom.lens, plain).Render(phantom.scene);
    std::vector<double> found;
    for (const Vec2& way : {Vec2(1, 0), Vec2(0, -1)})
      for (int d = 1; d < 100; ++d)
        if (At(with, at + d * way) != At(without, at + d * way)) {
          found.push_back(d);
          break;
        }
    return found;
  };
  const auto near = ring_px(3.0), far = ring_px(6.0);
  ASSERT_EQ(near.size(), 2u);
  ASSERT_EQ(far.size(), 2u);
  const double expected = 3.0 * phantom.lens.fx / phantom.lens.Depth(middle);
  for (int k : {0, 1}) EXPECT_NEAR(far[k] - near[k], expected, 0.15 * expected + 1.5) << k;
}

TEST_F(Overlay, FeaturesAreDrawnInTheColourOfTheirState) {
  FeatureSet features;
  features.id = {1, 2};
  features.pixels.resize(2, 2);
  features.pixels << 30, 200, 60, 200;
  features.status = {FeatureStatus::Tracked, FeatureStatus::Rejected};
  phantom.scene.features = &features;
  plain.show_features = true;
  const Image picture = OverlayRenderer(phantom.lens, plain).Render(phantom.scene);
  EXPECT_GT(At(picture, {30, 200}).y(), 200);
  EXPECT_GT(At(picture, {60, 200}).x(), 200);
  EXPECT_LT(At(picture, {60, 200}).y(), 120);
}

TEST_F(Overlay, NothingToDrawIsTheVideo) {
  OverlayScene scene;
  scene.frame = phantom.scene.frame;
  EXPECT_EQ(OverlayRenderer(phantom.lens, plain).Render(scene).data, Raw().data);
}

TEST_F(Overlay, WhatDoesNotFitIsNamed) {
  OverlayRenderer renderer(phantom.lens, {});
  OverlayScene scene = phantom.scene;
  scene.frame.image = testing::TissuePicture(100, 80);
  try {
    renderer.Render(scene);
    FAIL() << "a frame of another size was drawn on";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("100x80"), std::string::npos) << error.what();
    EXPECT_EQ(error.Element(), "frame 81");
  }
  scene = phantom.scene;
  scene.organ_cut_face.pop_back();
  EXPECT_THROW(renderer.Render(scene), InputError);
  scene = phantom.scene;
  Image mask = phantom.instruments;
  mask.data.pop_back();
  scene.instruments = &mask;
  EXPECT_THROW(renderer.Render(scene), InputError);
  scene = phantom.scene;
  SurfaceMesh bad = phantom.organ;
  bad.points(7, 1) = std::nan("");
  scene.organ = &bad;
  EXPECT_THROW(renderer.Render(scene), InputError);
  bad = phantom.organ;
  bad.triangles(3, 2) = static_cast<Index>(bad.points.rows());
  EXPECT_THROW(renderer.Render(scene), InputError);
  CameraModel broken = phantom.lens;
  broken.fx = std::nan("");
  EXPECT_THROW(OverlayRenderer(broken, {}), InputError);
}

TEST(OverlayPresets, NamesAreThoseOfTheDocumentation) {
  EXPECT_EQ(OverlayPresetFromName("see-through"), OverlayPreset::SeeThrough);
  EXPECT_THROW(OverlayPresetFromName("fancy"), UsageError);
}

TEST(CoverageMap, ALineCoversItsWidth) {
  CoverageMap map(40, 40);
  Pixels line(2, 2);
  line << 10.3, 20.4, 29.7, 20.4;
  map.DrawPolyline(line, 3.0);
  double column = 0;
  for (int y = 0; y < 40; ++y) column += map.Row(y)[20] / 255.0;
  EXPECT_NEAR(column, 3.0, 0.05);
  EXPECT_EQ(map.Row(20)[5], 0);
}

TEST(CoverageMap, SmoothingKeepsTheSumAwayFromBorders) {
  CoverageMap map(30, 30);
  map.Row(12)[15] = 160;
  map.Row(13)[16] = 80;
  map.Smooth({5, 5, 25, 25}, 1.0);
  int sum = 0;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 30; ++x) sum += map.Row(y)[x];
  EXPECT_NEAR(sum, 240, 12);
  EXPECT_EQ(map.Row(12)[15], (4 * 160 + 80) / 16);
}

TEST(CoverageMap, DistancesAreEuclidean) {
  const int w = 50, h = 40;
  std::vector<std::uint8_t> mask(std::size_t(w) * h);
  const std::pair<int, int> seeds[] = {{10, 10}, {30, 25}, {31, 25}};
  for (const auto& [x, y] : seeds) mask[std::size_t(y) * w + x] = 1;
  const PixelBox box{3, 2, 47, 38};
  const std::vector<float> distance = DistanceToMask(mask, w, box);
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      double nearest = 1e9;
      for (const auto& [u, v] : seeds) nearest = std::min(nearest, std::hypot(x - u, y - v));
      ASSERT_NEAR(distance[std::size_t(y - box.y0) * 44 + x - box.x0], nearest, 1e-4);
    }
}

TEST(ImageEncoding, PngKeepsEveryPixel) {
  const Image image = *testing::TissuePicture(33, 21);
  const std::string file = ::testing::TempDir() + "/kerf-picture.png";
  WritePng(file, image);
  const Image back = ReadPng(file);
  EXPECT_EQ(back.width, 33);
  EXPECT_EQ(back.data, image.data);
  EXPECT_THROW(ReadPng("/nonexistent.png"), InputError);
  EXPECT_THROW(WritePng("/nonexistent/a.png", image), InputError);
}

TEST(StructuralSimilarity, SeesMovedEdgesAndNotShades) {
  const Image a = *testing::TissuePicture(160, 90);
  Image lighter = a, moved = a;
  for (auto& v : lighter.data) v = static_cast<std::uint8_t>(std::min(255, v + 4));
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x + 6 < 160; ++x)
      for (int k = 0; k < 3; ++k)
        moved.data[3 * (y * 160 + x) + k] = a.data[3 * (y * 160 + x + 6) + k];
  EXPECT_NEAR(testing::StructuralSimilarity(a, a), 1.0, 1e-12);
  EXPECT_GT(testing::StructuralSimilarity(a, lighter), 0.97);
  EXPECT_LT(testing::StructuralSimilarity(a, moved), 0.9);
}

}  // namespace
}  // namespace kerf
