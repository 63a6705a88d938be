#include <gtest/gtest.h>

#include "Fuzz/CutSequences.h"
#include "Fuzz/ShrinkSequence.h"

namespace kerf::testing {
namespace {

/// A short run of the fuzz target: 25 sequences each; kerf-cut-fuzz runs as many as wanted.
class CutSequences : public ::testing::TestWithParam<unsigned> {};

TEST_P(CutSequences, KeepEveryGuarantee) {
  int done = 0, refused = 0, partial = 0, partial_joined = 0;
  for (unsigned seed = 25 * GetParam(); seed < 25 * (GetParam() + 1); ++seed) {
    const CutSequence sequence = MakeCutSequence(seed);
    const CutSequenceResult result = RunCutSequence(sequence);
    EXPECT_EQ(result.failure, "") << "seed " << seed << " (" << sequence.name << ")";
    EXPECT_EQ(result.missed_separations, 0) << "seed " << seed << " (" << sequence.name << ")";
    done += result.done;
    refused += result.refused;
    partial += result.partial;
    partial_joined += result.partial_joined;
  }
  EXPECT_GT(done, 30);
  EXPECT_LT(refused, 0.05 * done);  // coarse meshes, tight bends
  EXPECT_LE(partial, 0.05 * done);  // 0.7 % in a long run
  EXPECT_EQ(partial_joined, 0);
}

/// The shrinker finds the one triangle in one increment that a made-up fault depends on.
TEST(ShrinkSequence, KeepsOnlyWhatFails) {
  constexpr unsigned kSeed = 4;
  const CutSequence sequence = MakeCutSequence(kSeed);
  std::size_t guilty = 0;
  while (sequence.completes[guilty]) ++guilty;
  const CutSurface& surface = sequence.surfaces[guilty];
  const auto corners = [](const CutSurface& s, Index t) {
    Eigen::Matrix<double, 3, 3> x;
    for (int k = 0; k < 3; ++k) x.row(k) = s.points.row(s.triangles(t, k));
    return x;
  };
  const auto wanted = corners(surface, static_cast<Index>(surface.triangles.rows()) / 3);
  const auto shrunk = Shrink(sequence, [&](const CutSequence& part) {
    for (const CutSurface& s : part.surfaces)
      for (Index t = 0; t < s.triangles.rows(); ++t)
        if (corners(s, t) == wanted) return true;
    return false;
  });
  ASSERT_EQ(shrunk.kept.size(), 1u);
  const CutSequence again = Kept(MakeCutSequence(kSeed), shrunk.kept, shrunk.deformed);
  ASSERT_EQ(again.surfaces.size(), 1u);
  EXPECT_EQ(again.positions.rows(), 0);
  if (!again.completes[0]) {
    ASSERT_EQ(again.surfaces[0].triangles.rows(), 1);
    EXPECT_EQ(corners(again.surfaces[0], 0), wanted);
  }
  EXPECT_NE(WriteTest(kSeed, shrunk).find("MakeCutSequence(4)"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Seeds, CutSequences, ::testing::Range(0u, 6u));

/// Sequences that broke a guarantee once. 176, 288, 367, 510: the demanded angle was relaxed after
/// an earlier cut. 614, 775: a vertex that slid by weights of exactly (1, w, −w, 0) was taken for a
/// copy. 34, 65, 239: tissue stayed joined where S crossed another sheet of itself. 642, 772, 1585:
/// an older cut's front touched S in one vertex. 921, 1274, 1621: elements that S only entered
/// before the others around were cut.
TEST(CutSequencesKept, StayRepaired) {
  for (unsigned seed : {176u, 288u, 367u, 510u, 614u, 775u, 34u, 65u, 239u, 642u, 772u, 1585u, 921u,
                        1274u, 1621u}) {
    const CutSequence sequence = MakeCutSequence(seed);
    const CutSequenceResult result = RunCutSequence(sequence);
    EXPECT_EQ(result.failure, "") << "seed " << seed << " " << sequence.name;
    EXPECT_EQ(result.missed_separations, 0) << "seed " << seed << " " << sequence.name;
  }
}

}  // namespace
}  // namespace kerf::testing
