#pragma once

#include "Core/Progress.h"
#include "Core/Volume.h"
#include "Phantom/PhantomScenario.h"

namespace kerf {

struct PhantomCt {
  Volume ct;  ///< HU; excretory phase: parenchyma about 165, tumour 80, calyces 480, fat −100
  LabelMap labels;  ///< Label values; partial volumes decided at 50 %
};

/// CT of the kidney phantom: partial volumes and the scanner's point spread by the error function
/// of the distance to each surface, neighbouring organs, correlated noise. Spacing 0.95 × 0.95
/// × 1.25 mm.
PhantomCt MakePhantomCt(const PhantomSetup& setup, Progress& progress);

}  // namespace kerf
