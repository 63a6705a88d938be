// Random cut sequences: kerf-cut-fuzz [first seed] [count]. Prints each sequence that breaks a
// guarantee or where a complete cut leaves tissue joined, as the body of a test
// of its smallest failing part; status 1 if any, and where more increments than usual were refused
// or said that a part of S stayed uncut.
#include <cstdio>
#include <cstdlib>

#include "Fuzz/CutSequences.h"
#include "Fuzz/ShrinkSequence.h"

namespace {

// Ceilings: about one and a half times the share in 2,000 sequences, and a few for short runs, in
// which one sequence may say it of each of its increments.
struct Ceiling {
  double share;
  int few;
  bool Exceeded(int count, int of) const { return count > few + share * of; }
};
constexpr Ceiling kRefused{0.004, 5};  // of the increments that had something to cut
constexpr Ceiling kPartial{0.01, 8};   // of those that were cut
constexpr Ceiling kJoined{0.001, 2};   // of the complete cuts: partial, and tissue left joined

/// A test of the smallest part of the sequence that fails in the same way.
std::string SmallestTest(unsigned seed, const kerf::testing::CutSequence& sequence, bool broken) {
  return WriteTest(seed, kerf::testing::Shrink(sequence, [broken](const auto& part) {
                     const auto result = kerf::testing::RunCutSequence(part);
                     return broken ? !result.failure.empty() : result.missed_separations > 0;
                   }));
}

}  // namespace

int main(int argc, char** argv) {
  const unsigned first = argc > 1 ? unsigned(std::atoi(argv[1])) : 0;
  const unsigned count = argc > 2 ? unsigned(std::atoi(argv[2])) : 2000;
  int increments = 0, done = 0, refused = 0, missed = 0, broken = 0;
  int complete = 0, complete_across = 0, missed_across = 0;
  int partial = 0, partial_complete = 0, partial_joined = 0;
  double angle = 180, deformed = 180, share = 1, vertices = 0, tets = 0;
  int chips = 0;
  for (unsigned seed = first; seed < first + count; ++seed) {
    const auto sequence = kerf::testing::MakeCutSequence(seed);
    const auto result = kerf::testing::RunCutSequence(sequence);
    increments += result.increments;
    done += result.done;
    refused += result.refused;
    missed += result.missed_separations;
    partial += result.partial;
    partial_complete += result.partial_complete;
    partial_joined += result.partial_joined;
    complete += result.complete;
    complete_across += result.complete_across;
    missed_across += result.missed_across;
    angle = std::min(angle, result.smallest_dihedral_deg);
    deformed = std::min(deformed, result.smallest_deformed_deg);
    share = std::min(share, result.smallest_volume_share);
    vertices = std::max(vertices, result.most_new_vertices);
    tets = std::max(tets, result.most_new_tets);
    chips += result.chips;
    if (!result.failure.empty() || result.missed_separations > 0)
      std::printf("%s", SmallestTest(seed, sequence, !result.failure.empty()).c_str());
    if (!result.failure.empty()) {
      ++broken;
      std::printf("seed %u (%s): %s\n", seed, sequence.name.c_str(), result.failure.c_str());
    } else if (result.refused > 0 || result.missed_separations > 0) {
      std::printf("seed %u (%s): %d refused, %d not separated, worst %.2f deg\n", seed,
                  sequence.name.c_str(), result.refused, result.missed_separations,
                  result.smallest_dihedral_deg);
    }
  }
  std::printf(
      "%u sequences, %d increments: %d cut, %d refused, %d not separated, %d broken; "
      "smallest angle %.2f, deformed %.2f deg\n",
      count, increments, done, refused, missed, broken, angle, deformed);
  std::printf(
      "smallest tetrahedron made: %.2g of the mean one; at most %.2f new vertices and %.2f new "
      "tetrahedra for one with something to cut; %d chips stayed joined\n",
      share, vertices, tets, chips);
  std::printf("%d of %d complete cuts across others and %d of %d alone left tissue joined\n",
              missed_across, complete_across, missed - missed_across, complete - complete_across);
  std::printf(
      "%d increments said that a part of S stayed uncut; of %d of these that were complete cuts %d "
      "left tissue joined\n",
      partial, partial_complete, partial_joined);
  const bool too_many = kRefused.Exceeded(refused, done + refused) ||
                        kPartial.Exceeded(partial, done) ||
                        kJoined.Exceeded(partial_joined, complete + partial_complete);
  if (too_many) std::printf("more increments than usual were refused or cut in part\n");
  return broken + missed > 0 || too_many;
}
