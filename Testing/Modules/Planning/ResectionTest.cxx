#include <gtest/gtest.h>

#include <cmath>

#include "Geometry/EmbedPoints.h"
#include "Session/PlanningResection.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

Progress silent;

/// Box 60 × 40 × 20 mm around the origin with a ball of a tumour and a straight vessel.
PlanningModel BoxModel() {
  PlanningModel model;
  model.mesh = testing::BoxMesh({60, 40, 20}, 24, 16, 8);
  testing::PaintSphere({18, 0, 0}, 6, Label::Tumour, &model.mesh);
  model.organ_surface = BoundarySurface(model.mesh, model.mesh.rest);
  model.quality = MeasureQuality(model.mesh, model.mesh.rest);
  for (const auto& [name, surface] :
       {std::pair<std::string, SurfaceMesh>{"tumour", testing::SphereSurface({18, 0, 0}, 6, 4)},
        {"internal", testing::TubeSurface({-25, 0, 0}, {-15, 0, 0}, 2, 48, 12)}}) {
    Structure s;
    s.name = name;
    s.rest = surface;
    s.embedding = EmbedPoints(model.mesh, surface.points);
    model.structures.push_back(s);
  }
  return model;
}

/// Line across the box's top at x, down to the depth.
ResectionPlan PlanAt(double x, double depth_mm) {
  ResectionPlan plan;
  plan.line.resize(3, 3);
  plan.line << x, -20, 10, x, 0, 10, x, 20, 10;
  plan.direction = {0, 0, -1};
  plan.depth_mm = depth_mm;
  plan.margin_mm = 5;
  return plan;
}

}  // namespace

TEST(Resection, VolumesAndDistancesOfABoxAreExact) {
  const PlanningModel model = BoxModel();
  const ResectionMeasures m = MeasureResection(model, PlanAt(4.3, 30), silent);
  ASSERT_TRUE(m.divides) << m.note;
  EXPECT_NEAR(m.organ_ml, 48, 1e-9);
  // The tumour's side: x from 4.3 to 30.
  EXPECT_NEAR(m.removed_ml, 20.56, 1e-6);
  EXPECT_NEAR(m.remnant_ml, 27.44, 1e-6);
  EXPECT_NEAR(m.remnant_percent, 100 * 27.44 / 48, 1e-5);
  EXPECT_NEAR(m.tumour_left_ml, 0, 1e-12);
  EXPECT_NEAR(m.to_tumour_mm, 7.7, 0.02);     // 18 − 6 − 5
  EXPECT_NEAR(m.to_internal_mm, 19.3, 1e-6);  // 4.3 − (−15)
  EXPECT_TRUE(m.margin_kept);
}

TEST(Resection, ThroughTumourAndVesselIsSaid) {
  const PlanningModel model = BoxModel();
  const ResectionMeasures through = MeasureResection(model, PlanAt(17.9, 30), silent);
  EXPECT_EQ(through.to_tumour_mm, 0);
  EXPECT_FALSE(through.margin_kept);
  const ResectionMeasures vessel = MeasureResection(model, PlanAt(-20.6, 30), silent);
  EXPECT_EQ(vessel.to_internal_mm, 0);
  EXPECT_NEAR(vessel.remnant_ml, 7.52, 1e-6);  // the smaller piece holds no tumour
}

TEST(Resection, MarginDecidesAtTheExactDistance) {
  const PlanningModel model = BoxModel();
  ResectionPlan plan = PlanAt(5, 30);
  plan.margin_mm = 6.9;
  EXPECT_TRUE(MeasureResection(model, plan, silent).margin_kept);
  plan.margin_mm = 7.1;
  EXPECT_FALSE(MeasureResection(model, plan, silent).margin_kept);
}

TEST(Resection, ShallowSheetDoesNotDivideAndSaysWhatToDo) {
  const PlanningModel model = BoxModel();
  const ResectionMeasures m = MeasureResection(model, PlanAt(4.3, 9), silent);
  EXPECT_FALSE(m.divides);
  EXPECT_NE(m.note.find("deeper"), std::string::npos) << m.note;
  ResectionPlan none;
  EXPECT_FALSE(MeasureResection(model, none, silent).divides);
}

TEST(Resection, ANoteTellsWhatWasNotCut) {
  CutReport report;
  report.done = true;
  EXPECT_EQ(ResectionNote(report, true), "");
  report.partial = true;
  report.reason = "for a reason";
  EXPECT_NE(ResectionNote(report, true).find("whole sheet (for a reason)"), std::string::npos);
  EXPECT_EQ(ResectionNote(report, true).find("divide"), std::string::npos);
  EXPECT_NE(ResectionNote(report, false).find("does not divide"), std::string::npos);
  report = {};
  report.reason = "for a reason";
  EXPECT_NE(ResectionNote(report, false).find("could not be cut along this sheet (for a reason)"),
            std::string::npos);
}

TEST(Resection, LineLiesOnTheSurfaceAndDirectionPointsInwards) {
  const PlanningModel model = BoxModel();
  const ResectionPlan plan = PlanAt(5, 30);
  const Points line = LineOnSurface(model.organ_surface, plan.line);
  EXPECT_GE(line.rows(), 20);
  for (const double d : DistancesTo(model.organ_surface, line)) EXPECT_LT(d, 1e-9);
  Points middle(2, 3);
  middle << 5, -10, 10, 5, 10, 10;
  EXPECT_LT((SuggestDirection(model.organ_surface, middle) - Vec3(0, 0, -1)).norm(), 1e-9);
}

TEST(Resection, TissueWithinTheMarginIsABall) {
  PlanningModel model;
  model.mesh = testing::BoxMesh({60, 60, 60}, 30, 30, 30);
  Structure tumour;
  tumour.name = "tumour";
  tumour.rest = testing::SphereSurface({0, 0, 0}, 8, 4);
  model.structures.push_back(tumour);
  const double ball_ml = 4.0 / 3.0 * std::acos(-1.0) * std::pow(13, 3) / 1000;
  EXPECT_NEAR(TissueWithinMargin_ml(model, 5, silent) / ball_ml, 1.0, 0.02);
  model.structures.clear();
  EXPECT_EQ(TissueWithinMargin_ml(model, 5, silent), 0);
}

}  // namespace kerf
