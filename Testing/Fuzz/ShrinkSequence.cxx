#include "Fuzz/ShrinkSequence.h"

#include <sstream>

namespace kerf::testing {

CutSequence Kept(const CutSequence& sequence, const std::vector<KeptIncrement>& kept,
                 bool deformed) {
  CutSequence part;
  part.mesh = sequence.mesh;
  part.name = sequence.name;
  if (deformed) part.positions = sequence.positions;
  for (const KeptIncrement& k : kept) {
    CutSurface surface = sequence.surfaces[k.increment];
    surface.triangles = Triangles(surface.triangles.middleRows(k.first, k.last - k.first));
    part.surfaces.push_back(std::move(surface));
    part.completes.push_back(sequence.completes[k.increment]);
    part.cut.push_back(sequence.cut[k.increment]);
  }
  return part;
}

ShrunkSequence Shrink(const CutSequence& sequence,
                      const std::function<bool(const CutSequence&)>& fails) {
  std::vector<KeptIncrement> kept;
  for (std::size_t i = 0; i < sequence.surfaces.size(); ++i)
    kept.push_back(
        {static_cast<int>(i), 0, static_cast<Index>(sequence.surfaces[i].triangles.rows())});
  bool deformed = sequence.positions.rows() > 0;
  const auto still_fails = [&](const std::vector<KeptIncrement>& part, bool with_positions) {
    return fails(Kept(sequence, part, with_positions));
  };
  if (deformed && still_fails(kept, false)) deformed = false;
  for (bool smaller = true; smaller;) {
    smaller = false;
    for (std::size_t i = kept.size(); i-- > 0;) {
      std::vector<KeptIncrement> less = kept;
      less.erase(less.begin() + i);
      if (less.empty() || !still_fails(less, deformed)) continue;
      kept = std::move(less);
      smaller = true;
    }
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (sequence.completes[kept[i].increment]) continue;
      for (bool at_start : {true, false})
        for (Index step = (kept[i].last - kept[i].first) / 2; step > 0; step /= 2)
          while (kept[i].last - kept[i].first > step) {
            std::vector<KeptIncrement> less = kept;
            (at_start ? less[i].first : less[i].last) += at_start ? step : -step;
            if (!still_fails(less, deformed)) break;
            kept = std::move(less);
            smaller = true;
          }
    }
  }
  return {Kept(sequence, kept, deformed), kept, deformed};
}

std::string WriteTest(unsigned seed, const ShrunkSequence& shrunk) {
  std::ostringstream out;
  out << "TEST(CutSequencesKept, Seed" << seed << ") {\n  const CutSequence sequence = Kept("
      << "MakeCutSequence(" << seed << "), {";
  for (std::size_t i = 0; i < shrunk.kept.size(); ++i) {
    const KeptIncrement& k = shrunk.kept[i];
    out << (i > 0 ? ", {" : "{") << k.increment << ", " << k.first << ", " << k.last << "}";
  }
  out << "}, " << (shrunk.deformed ? "true" : "false")
      << ");\n  const CutSequenceResult result = RunCutSequence(sequence);\n"
      << "  EXPECT_EQ(result.failure, \"\");\n  EXPECT_EQ(result.missed_separations, 0);\n}\n";
  return out.str();
}

}  // namespace kerf::testing
