#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "Cutting/ExtrudePolyline.h"

namespace kerf::testing {
namespace {

Points Line(int n) {
  Points p(n, 3);
  for (int i = 0; i < n; ++i) p.row(i) << 3.0 * i, 0.4 * i * i, 10;
  return p;
}

Points Rays(int n) {
  Points d(n, 3);
  for (int i = 0; i < n; ++i) d.row(i) << 0.05 * i, 0, -1;
  return d.rowwise().normalized();
}

using Corner = std::array<double, 9>;
std::set<Corner> Triangles9(const CutSurface& s) {
  std::set<Corner> out;
  for (Index t = 0; t < s.triangles.rows(); ++t) {
    Corner c;
    for (int k = 0; k < 9; ++k) c[k] = s.points(s.triangles(t, k / 3), k % 3);
    out.insert(c);
  }
  return out;
}

TEST(ExtrudePolyline, CoversTheStripFromAboveToDepth) {
  Points line(2, 3);
  line << 0, 0, 0, 10, 0, 0;
  const CutSurface s = ExtrudePolyline(CutPolyline{line}, Vec3(0, 0, -2), 3, 7, 2.5);
  EXPECT_DOUBLE_EQ(s.points.col(2).maxCoeff(), 3);
  EXPECT_DOUBLE_EQ(s.points.col(2).minCoeff(), -7);
  double area = 0;
  for (Index t = 0; t < s.triangles.rows(); ++t) {
    const Vec3 a = s.points.row(s.triangles(t, 0)), b = s.points.row(s.triangles(t, 1)),
               c = s.points.row(s.triangles(t, 2));
    area += 0.5 * (b - a).cross(c - a).norm();
    EXPECT_LE((b - a).norm(), 2.5 * std::sqrt(2.0) + 1e-9);
  }
  EXPECT_NEAR(area, 100, 1e-9);
}

TEST(ExtrudePolyline, KeepsItsOldPartBitForBitAtEitherEnd) {
  const Points line = Line(8), rays = Rays(8);
  const auto whole = Triangles9(ExtrudePolyline(line, rays, 4, 30, 2));
  for (auto [first, count] : {std::pair{0, 5}, std::pair{3, 5}}) {
    const auto part = Triangles9(ExtrudePolyline(Points(line.middleRows(first, count)),
                                                 Points(rays.middleRows(first, count)), 4, 30, 2));
    for (const Corner& c : part) EXPECT_TRUE(whole.count(c));
  }
}

TEST(ExtrudePolyline, FewerThanTwoPointsGiveNothing) {
  Points same(3, 3);
  same << 1, 2, 3, 1, 2, 3, 1, 2, 3;
  EXPECT_EQ(ExtrudePolyline(same, Rays(3), 1, 1, 1).triangles.rows(), 0);
}

TEST(ExtrudePolyline, RejectsNonsense) {
  EXPECT_THROW(ExtrudePolyline(Line(3), Rays(2), 1, 1, 1), std::invalid_argument);
  EXPECT_THROW(ExtrudePolyline(Line(3), Rays(3), 1, 1, 0), std::invalid_argument);
  EXPECT_THROW(ExtrudePolyline(Line(3), Rays(3), -1, 1, 1), std::invalid_argument);
  EXPECT_THROW(ExtrudePolyline(CutPolyline{Line(3)}, Vec3::Zero(), 1, 1, 1), std::invalid_argument);
}

}  // namespace
}  // namespace kerf::testing
