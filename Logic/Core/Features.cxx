#include "Core/Features.h"

namespace kerf {

const char* ToString(FeatureStatus status) {
  switch (status) {
    case FeatureStatus::Tracked:
      return "tracked";
    case FeatureStatus::Lost:
      return "lost";
    case FeatureStatus::Rejected:
      return "rejected";
    case FeatureStatus::Occluded:
      return "occluded";
  }
  return "lost";
}

}  // namespace kerf
