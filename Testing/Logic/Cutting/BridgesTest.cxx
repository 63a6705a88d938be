// Whether tissue still hangs together across a cut.
#include <gtest/gtest.h>

#include "Cutting/Bridges.h"
#include "Cutting/ExtrudePolyline.h"
#include "Cutting/TetCutter.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

TetMesh Kidney() { return EllipsoidMesh({55, 35, 25}, 7); }

/// Across at x = 3, from beyond the rim to `to_y`.
CutSurface To(double to_y) {
  return RectangleCut({3, -40, -30}, {0, to_y + 40, 0}, {0, 0, 60}, 20, 20);
}

TEST(Bridges, ACutToItsEndIsNone) {
  for (double to_y : {5.0, 40.0}) {
    const TetMesh cut = TetCutter().Cut(Kidney(), To(to_y)).mesh;
    EXPECT_FALSE(JoinedAcross(cut, To(to_y))) << to_y;
  }
}

TEST(Bridges, TissueThatWasNotCutIsOne) {
  EXPECT_TRUE(JoinedAcross(Kidney(), To(5)));
  const TetMesh shorter = TetCutter().Cut(Kidney(), To(-15)).mesh;
  EXPECT_TRUE(JoinedAcross(shorter, To(15)));
}

TEST(Bridges, AThreadInTheMiddleIsOne) {
  const TetMesh threaded = TetCutter().Cut(Kidney(), WithHole(To(40), {3, 0, 0}, 5)).mesh;
  EXPECT_TRUE(JoinedAcross(threaded, To(40)));
  EXPECT_FALSE(JoinedAcross(TetCutter().Cut(threaded, To(40)).mesh, To(40)));
}

TEST(Bridges, WhereSDoesNotMeetTheOrganThereIsNone) {
  EXPECT_FALSE(JoinedAcross(Kidney(), RectangleCut({90, -40, -30}, {0, 80, 0}, {0, 0, 60}, 9, 9)));
  EXPECT_FALSE(JoinedAcross(Kidney(), {}));
}

}  // namespace
}  // namespace kerf::testing
