#pragma once

#include "CaseIO/StudyFolder.h"
#include "Core/Features.h"

namespace kerf {

/// Perfect tracks from a table in the place of a tracker: registration without tracking errors
/// (`--tracks`).
class TableTracker : public FeatureTracker {
 public:
  explicit TableTracker(TrackTable table) : table_(std::move(table)) {}
  /// All features of the table at their pixels in `frame`.
  FeatureSet Detect(const Frame& frame, const Image& organ_mask, int wanted) override;
  /// Invisible features are `occluded` and keep their last position; frames after the table's end:
  /// all `lost`.
  void Track(const Frame& frame, FeatureSet* features) override;
  int FrameCount() const { return table_.frames; }

 private:
  TrackTable table_;
};

}  // namespace kerf
