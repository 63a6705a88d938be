#pragma once

#include "Adapters/Itk/Field.h"

namespace kerf {

/// Divides a body into parts at its necks. Every part has a deepest point (half-thickness p); two
/// parts whose common neck has half-thickness s become one when s ≥ neck_ratio · p of the thinner
/// (or the two differ by less than tolerance_mm, which noise makes). A watershed of the depth with
/// that rule of merging, in one sweep from deep to shallow: scale-free, so that a vessel leaves the
/// organ it enters and a lobe does not.
/// @param depth_mm distance to the body's boundary, positive inside
/// @return part number from 0, −1 outside; numbers are in the order of depth
Field<std::int32_t> DivideAtNecks(const ScalarField& depth_mm, double neck_ratio,
                                  double tolerance_mm);

}  // namespace kerf
