// The look of the overlay, against pictures that were looked at. KERF_UPDATE_BASELINES=1 writes
// them anew.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>

#include "Adapters/Rendering/ImageEncoding.h"
#include "Adapters/Rendering/OverlayRenderer.h"
#include "Adapters/Rendering/VirtualDisplay.h"
#include "OverlayScenes.h"
#include "Support/ImageSimilarity.h"

namespace kerf {
namespace {

struct Golden {
  const char* name;
  std::function<void(OverlayOptions*, OverlayScene*)> setup;
};
void PrintTo(const Golden& g, std::ostream* out) { *out << g.name; }

OverlayLine Line(OverlayLine::Kind kind, std::initializer_list<Vec3> points) {
  OverlayLine line;
  line.kind = kind;
  line.current.resize(static_cast<Eigen::Index>(points.size()), 3);
  Eigen::Index i = 0;
  for (const Vec3& p : points) line.current.row(i++) = p.transpose();
  return line;
}

const Golden kGoldens[] = {
    {"full", [](OverlayOptions*, OverlayScene*) {}},
    {"outline", [](OverlayOptions* o, OverlayScene*) { o->preset = OverlayPreset::Outline; }},
    {"see-through",
     [](OverlayOptions* o, OverlayScene*) { o->preset = OverlayPreset::SeeThrough; }},
    {"amber",
     [](OverlayOptions*, OverlayScene* s) {
       s->status.gate = OverlayStatus::Gate::Amber;
       s->status.reason = "61 % of the features are lost";
       s->lines = {Line(OverlayLine::Kind::Proposed, {{-12, -22, -9}, {-8, -8, -19}, {-2, 4, -20}}),
                   Line(OverlayLine::Kind::Planned,
                        {{-36, -10, -10}, {-20, -10, -17}, {-14, 4, -19}, {-18, 15, -14}})};
     }},
    {"off",
     [](OverlayOptions*, OverlayScene* s) {
       s->status.gate = OverlayStatus::Gate::Off;
       s->status.reason = "tracking lost";
     }},
};

class GoldenOverlay : public ::testing::TestWithParam<Golden> {};

TEST_P(GoldenOverlay, LooksAsItDid) {
  std::string why;
  if (!RenderingAvailable(&why)) GTEST_SKIP() << why;
  testing::PhantomScene phantom = testing::MakePhantomScene(640, 360);
  testing::Bind(&phantom);
  OverlayOptions options;
  GetParam().setup(&options, &phantom.scene);
  const Image picture = OverlayRenderer(phantom.lens, options).Render(phantom.scene);
  const std::string file = std::string(KERF_BASELINES) + "/Overlay/" + GetParam().name + ".png";
  if (std::getenv("KERF_UPDATE_BASELINES")) {
    WritePng(file, picture);
    GTEST_SKIP() << "wrote " << file;
  }
  const double similarity = testing::StructuralSimilarity(picture, ReadPng(file));
  if (similarity < 0.985)
    WritePng(::testing::TempDir() + "/kerf-overlay-" + GetParam().name + ".png", picture);
  EXPECT_GE(similarity, 0.985) << "compare " << ::testing::TempDir() << "/kerf-overlay-"
                               << GetParam().name << ".png with " << file;
}

// The bound is worth something: a model that is 2 mm off fails it.
TEST(GoldenOverlayTwin, AMisplacedModelIsNoticed) {
  std::string why;
  if (!RenderingAvailable(&why)) GTEST_SKIP() << why;
  testing::PhantomScene phantom = testing::MakePhantomScene(640, 360);
  testing::Bind(&phantom);
  phantom.organ.points.col(0).array() += 2.0;
  const Image picture = OverlayRenderer(phantom.lens, {}).Render(phantom.scene);
  const Image golden = ReadPng(std::string(KERF_BASELINES) + "/Overlay/full.png");
  EXPECT_LT(testing::StructuralSimilarity(picture, golden), 0.97);
}

INSTANTIATE_TEST_SUITE_P(Looks, GoldenOverlay, ::testing::ValuesIn(kGoldens), [](const auto& info) {
  std::string name = info.param.name;
  for (char& c : name)
    if (c == '-') c = '_';
  return name;
});

}  // namespace
}  // namespace kerf
