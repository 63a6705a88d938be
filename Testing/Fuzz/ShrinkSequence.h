#pragma once

#include <functional>
#include <string>
#include <vector>

#include "Fuzz/CutSequences.h"

namespace kerf::testing {

/// What is kept of one increment of a sequence: triangles first … last − 1 of its surface.
struct KeptIncrement {
  int increment;
  Index first, last;
};

/// The sequence with only these increments, ascending, and these triangles of them.
CutSequence Kept(const CutSequence& sequence, const std::vector<KeptIncrement>& kept,
                 bool deformed);

/// A small part of a sequence that still fails.
struct ShrunkSequence {
  CutSequence sequence;
  std::vector<KeptIncrement> kept;
  bool deformed;
};

/// Leaves out increments, the deformation and ends of surfaces (the points of the cut's line that
/// were added first or last) as long as `fails`. Surfaces that are to complete a cut stay whole.
/// @param fails has to be true for the sequence itself
ShrunkSequence Shrink(const CutSequence& sequence,
                      const std::function<bool(const CutSequence&)>& fails);

/// A test that makes the shrunk sequence from its seed and demands that it keeps every guarantee.
std::string WriteTest(unsigned seed, const ShrunkSequence& shrunk);

}  // namespace kerf::testing
