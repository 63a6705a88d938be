#include "Adapters/Rendering/OverlayScene.h"

#include "Core/Errors.h"

namespace kerf {

OverlayPreset OverlayPresetFromName(const std::string& name) {
  if (name == "outline") return OverlayPreset::Outline;
  if (name == "see-through") return OverlayPreset::SeeThrough;
  if (name == "full") return OverlayPreset::Full;
  throw UsageError("unknown overlay preset '" + name + "': use outline, see-through or full");
}

}  // namespace kerf
