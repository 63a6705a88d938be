#include "Session/TableTracker.h"

namespace kerf {

FeatureSet TableTracker::Detect(const Frame& frame, const Image&, int) {
  FeatureSet features;
  features.id = table_.id;
  features.pixels = table_.rest_pixels;
  features.status.assign(table_.id.size(), FeatureStatus::Tracked);
  Track(frame, &features);
  return features;
}

void TableTracker::Track(const Frame& frame, FeatureSet* features) {
  for (Index i = 0; i < features->Size(); ++i) {
    if (frame.index < 0 || frame.index >= table_.frames) {
      features->status[i] = FeatureStatus::Lost;
      continue;
    }
    const Index row = table_.Row(frame.index, i);
    features->status[i] = table_.visible[row] ? FeatureStatus::Tracked : FeatureStatus::Occluded;
    if (table_.visible[row]) features->pixels.row(i) = table_.pixels.row(row);
  }
}

}  // namespace kerf
