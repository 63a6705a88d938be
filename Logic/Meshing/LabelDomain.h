#pragma once

#include <memory>

#include "Core/Volume.h"
#include "Meshing/DomainMesher.h"
#include "Meshing/LabelField.h"

namespace kerf {

/// Organ (everything that `organ` encloses) with the tumour as sub-domain. `tumour` may be empty.
/// The fields are kept by reference.
std::unique_ptr<DomainMesher> MakeLabelDomain(const LabelField& organ, const LabelField& tumour);

}  // namespace kerf
