#pragma once

#include "Adapters/Itk/Field.h"
#include "Adapters/Itk/Preset.h"

namespace kerf {

struct FoundOrgan {
  Vec3 seed_mm = Vec3::Zero();  ///< deepest point, LPS
  OrganPreset preset = OrganPreset::Kidney;
  double mean_hu = 0;
};

/// The one organ that fills a study's CT: the brightest thick body of soft tissue that does not run
/// out of the volume. The preset follows from contrast-filled calyces, brightness and size. @throws
/// InputError when there is none
FoundOrgan FindStudyOrgan(const Volume& ct, Progress& progress);

/// The liver without a seed: the thickest body of the preset's HU range, on the patient's right
/// where there is a choice.
/// @throws InputError when nothing of that kind is there
Vec3 FindLiverSeed(const Volume& ct, const OrganKnowledge& liver, Progress& progress);

}  // namespace kerf
