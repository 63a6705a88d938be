// Eq. (11), outliers, cut points, neighbourhood and the polygon that grows.
#include <gtest/gtest.h>

#include <cmath>

#include "Registration/CutPolygon.h"
#include "Registration/Divergence.h"
#include "Registration/NeighborGraph.h"

namespace kerf {
namespace {

/// Features on a grid with 4 mm spacing in the plane z = 0.
Points Grid(int nx, int ny) {
  Points p(nx * ny, 3);
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) p.row(j * nx + i) << 4.0 * i, 4.0 * j, 0.0;
  return p;
}

std::vector<char> All(const Points& p) { return std::vector<char>(p.rows(), 1); }

TEST(NeighborGraph, HoldsExactlyThePairsCloserThanTheRadius) {
  const Points p = Grid(5, 4);
  const NeighborGraph graph = BuildNeighborGraph(p, 6.0);
  int expected = 0;
  for (Index l = 0; l < p.rows(); ++l)
    for (Index m = l + 1; m < p.rows(); ++m) expected += (p.row(l) - p.row(m)).norm() < 6.0;
  EXPECT_EQ(graph.Size(), expected);
  for (Index e = 0; e < graph.Size(); ++e)
    EXPECT_NEAR(graph.rest_distance_mm[e],
                (p.row(graph.pairs[e][0]) - p.row(graph.pairs[e][1])).norm(), 1e-12);
}

TEST(NeighborGraph, CrossingPairsAreRemovedOthersKept) {
  const Points p = Grid(6, 6);
  const NeighborGraph graph = BuildNeighborGraph(p, 9.0);
  const Vec3 center(10.0, 10.0, 0.0);
  const NeighborGraph kept = RemoveCrossing(graph, p, center, 3.0);
  EXPECT_LT(kept.Size(), graph.Size());
  for (Index e = 0; e < kept.Size(); ++e) {
    const Vec3 a = p.row(kept.pairs[e][0]).transpose(), b = p.row(kept.pairs[e][1]).transpose();
    for (double t = 0.0; t <= 1.0; t += 0.01) EXPECT_GT((a + t * (b - a) - center).norm(), 3.0);
  }
}

TEST(Divergence, EqualDisplacementsGiveZero) {
  const Points p = Grid(5, 5);
  const NeighborGraph graph = BuildNeighborGraph(p, 9.0);
  const Points targets = p.rowwise() + Eigen::RowVector3d(3.0, -7.0, 11.0);
  EXPECT_LT(Divergence(graph, p, targets, All(p)).maxCoeff(), 1e-12);
}

TEST(Divergence, IsTheProductOfStretchAndDivergingResiduals) {
  Points rest(2, 3), current(2, 3), targets(2, 3);
  rest << 0, 0, 0, 10, 0, 0;
  current << 0, 0, 0, 12, 0, 0;
  targets << -1, 0, 0, 14, 0, 0;  // δ¹ = 15, d_l = 1, d_m = −2
  const NeighborGraph graph = BuildNeighborGraph(rest, 20.0);
  EXPECT_NEAR(Divergence(graph, current, targets, All(rest))[0], 15.0 / 10.0 * 3.0, 1e-12);
}

TEST(Divergence, UnusableFeaturesTakeNoPart) {
  const Points p = Grid(5, 5);
  const NeighborGraph graph = BuildNeighborGraph(p, 9.0);
  Points targets = p;
  targets.row(12) << 500.0, 0.0, 0.0;
  auto usable = All(p);
  usable[12] = 0;
  const Eigen::VectorXd mu = Divergence(graph, p, targets, usable);
  EXPECT_LT(mu.maxCoeff(), 1e-12);
  EXPECT_TRUE(FindOutliers(mu, 8.0, 0.5).pairs.empty());
}

TEST(Divergence, MismatchedLengthsAreRefused) {
  const Points p = Grid(3, 3);
  const NeighborGraph graph = BuildNeighborGraph(p, 9.0);
  EXPECT_THROW(Divergence(graph, p, p.topRows(4), All(p)), std::invalid_argument);
}

// A uniform stretch of 1.86 that the model follows only half way is no cut: all pairs diverge
// alike.
TEST(Outliers, UniformStretchOf186PercentHasNone) {
  const Points p = Grid(20, 8);
  const NeighborGraph graph = BuildNeighborGraph(p, 10.0);
  Points targets = p, current = p;
  targets.col(0) *= 1.86;
  current.col(0) *= 1.43;
  const Outliers out = FindOutliers(Divergence(graph, current, targets, All(p)), 8.0, 0.5);
  EXPECT_TRUE(out.pairs.empty());
  EXPECT_GT(out.mean_mm, 0.5);
}

// The positive twin: halves that part across x = 38 give outliers across that line only, strongest
// first.
TEST(Outliers, AnOpeningGapIsFoundWhereItIs) {
  const Points p = Grid(20, 8);
  const NeighborGraph graph = BuildNeighborGraph(p, 10.0);
  Points targets = p;
  for (Index i = 0; i < p.rows(); ++i)
    if (p(i, 1) > 14.0) targets(i, 0) += p(i, 0) > 38.0 ? 5.0 : -5.0;
  const Eigen::VectorXd mu = Divergence(graph, p, targets, All(p));
  const Outliers out = FindOutliers(mu, 8.0, 0.5);
  ASSERT_GT(out.pairs.size(), 8u);
  for (std::size_t k = 1; k < out.pairs.size(); ++k)
    EXPECT_GE(mu[out.pairs[k - 1]], mu[out.pairs[k]]);
  const auto point = CutPoint(out, mu, graph, p, 8);
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->x(), 38.0, 1.0);
  EXPECT_GT(point->y(), 14.0);
  EXPECT_FALSE(CutPoint(out, mu, graph, p, static_cast<int>(out.pairs.size())));
}

// A band pulled at one end by springs that give: the lag falls off from the end within a few
// millimetres, all in one direction. No cut; the twin parts two ways and is one.
TEST(Outliers, ALagThatFallsOffSteeplyIsNoCut) {
  const Points p = Grid(20, 8);
  const NeighborGraph graph = BuildNeighborGraph(p, 10.0);
  Points lag = p, gap = p;
  for (Index i = 0; i < p.rows(); ++i) {
    lag(i, 0) += 3.0 * std::exp(-p(i, 0) / 3.0);
    gap(i, 0) += (p(i, 0) > 38.0 ? 1.0 : -1.0) * 3.0 * std::exp(-std::abs(p(i, 0) - 38.0) / 3.0);
  }
  Outliers out = FindOutliers(Divergence(graph, p, lag, All(p)), 8.0, 0.5);
  ASSERT_GT(out.pairs.size(), 8u);
  KeepOpposed(graph, p, lag, &out);
  EXPECT_TRUE(out.pairs.empty());
  out = FindOutliers(Divergence(graph, p, gap, All(p)), 8.0, 0.5);
  KeepOpposed(graph, p, gap, &out);
  EXPECT_GT(out.pairs.size(), 8u);
}

// A few diverging pairs at each end of an organ are two regions: neither is enough for a cut, and
// nothing lies in the middle between them. Once one region has enough of them the point lies there.
TEST(Outliers, RegionsApartDoNotAddUpToACut) {
  const Points p = Grid(20, 8);
  const NeighborGraph graph = BuildNeighborGraph(p, 6.0);
  Points targets = p;
  const auto pull = [&](Index i, double by_mm) { targets(i, 1) += by_mm; };
  pull(3, 6.0);             // one feature at the near end
  pull(p.rows() - 4, 6.0);  // one at the far end
  Eigen::VectorXd mu = Divergence(graph, p, targets, All(p));
  Outliers out = FindOutliers(mu, 8.0, 0.5);
  const int both = static_cast<int>(out.pairs.size());
  const int one = static_cast<int>(LargestRegion(out, graph).size());
  ASSERT_GT(both, one);
  EXPECT_FALSE(CutPoint(out, mu, graph, p, one));
  const auto point = CutPoint(out, mu, graph, p, one - 1);
  ASSERT_TRUE(point);
  const double near = (*point - p.row(3).transpose()).norm();
  const double far = (*point - p.row(p.rows() - 4).transpose()).norm();
  EXPECT_LT(std::min(near, far), 6.0);
}

TEST(CutPolygon, GrowsAtItsNearestEndAndReachesAhead) {
  CutPolygon polygon;
  EXPECT_FALSE(polygon.Insert({0, 0, 0}, 7.0));
  EXPECT_EQ(polygon.Committed().points.rows(), 0);
  EXPECT_TRUE(polygon.Insert({5, 0, 0}, 7.0));
  Points line = polygon.Committed().points;
  EXPECT_NEAR(line(0, 0), -7.0, 1e-12);  // over the boundary at the entry
  EXPECT_NEAR(line(line.rows() - 1, 0), 12.0, 1e-12);
  // A point that the line already covers moves nothing that is committed.
  const Index before = line.rows();
  EXPECT_TRUE(polygon.Insert({9, 0.5, 0}, 7.0));
  line = polygon.Committed().points;
  EXPECT_GE(line.rows(), before);
  EXPECT_NEAR(line(line.rows() - 1, 0), 9.0 + 7.0 * 4.0 / std::hypot(4.0, 0.5), 1e-9);
  // At the other end.
  EXPECT_TRUE(polygon.Insert({-9, 0, 0}, 7.0));
  line = polygon.Committed().points;
  EXPECT_NEAR(line(0, 0), -16.0, 1e-9);
}

TEST(CutPolygon, CommittedPointsNeverMove) {
  CutPolygon polygon;
  Points last(0, 3);
  for (int i = 0; i < 12; ++i) {
    polygon.Insert({4.0 * i, std::sin(i), 0.3 * i}, 5.0);
    const Points line = polygon.Committed().points;
    for (Index r = 0; r < last.rows(); ++r) EXPECT_EQ(line.row(r), last.row(r));
    last = line;
  }
  EXPECT_GT(last.rows(), 12);
}

}  // namespace
}  // namespace kerf
