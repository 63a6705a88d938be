#include <gtest/gtest.h>

#include <random>

#include "Cutting/CutPatch.h"
#include "Cutting/ShortLists.h"
#include "Support/Draws.h"

namespace kerf::testing {
namespace {

TEST(ShortLists, KeepTheirNumbersAndOrderAsTheyGrow) {
  ShortLists lists;
  std::vector<std::vector<int>> expected(20);
  for (int list = 0; list < 20; ++list) lists.Add(list % 3);
  for (int n = 0; n < 2000; ++n) {
    const int list = n * n % 20;
    lists.Push(list, n);
    expected[list].push_back(n);
  }
  const ShortLists copy = lists;
  lists.RemoveIf(4, [](int n) { return n % 3 == 0; });
  for (int list = 0; list < 20; ++list)
    EXPECT_EQ(std::vector<int>(copy[list].begin(), copy[list].end()), expected[list]);
  for (int n : lists[4]) EXPECT_NE(n % 3, 0);
  EXPECT_LT(lists[4].size(), copy[4].size());
}

/// The quick look at the angles never calls a sharp tetrahedron blunt, and seldom a blunt one
/// sharp.
TEST(CutPatch, TheQuickLookAtAnglesIsSafe) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> at(-1, 1), share(0, 1);
  const double cosine = CosineOf(3);
  int blunt = 0, called_blunt = 0;
  for (int i = 0; i < 20000; ++i) {
    std::array<Vec3, 4> x;
    for (Vec3& p : x) {
      p = DrawVec3([&] { return at(engine); });
      p.z() *= std::pow(share(engine), 4);
    }
    const double smallest = CosineOfSmallestDihedral(x[0], x[1], x[2], x[3]);
    const bool quick = AllAnglesAbove(cosine, x[0], x[1], x[2], x[3]);
    if (quick) {
      EXPECT_LE(smallest, cosine);
    }
    blunt += smallest < cosine;
    called_blunt += quick;
  }
  EXPECT_GT(blunt, 5000);
  EXPECT_LT(blunt, 15000);
  EXPECT_GE(called_blunt, 0.999 * blunt);
}

}  // namespace
}  // namespace kerf::testing
