#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "Core/Frame.h"
#include "Core/Types.h"

namespace kerf {

/// tracked: seen and believed; lost: the tracker has no position; rejected: seen but inconsistent;
/// occluded: known to be behind an instrument or out of the image. Only `tracked` features pull on
/// the model.
enum class FeatureStatus { Tracked, Lost, Rejected, Occluded };
const char* ToString(FeatureStatus status);

/// 2-D features p_f in one frame. All arrays have the same length; a feature keeps its row for its
/// whole life.
struct FeatureSet {
  std::vector<int> id;
  Pixels pixels;  ///< N×2, raw distorted px; last known position where not tracked
  std::vector<FeatureStatus> status;

  Index Size() const { return static_cast<Index>(id.size()); }
};

/// Where 2-D features come from and how they are followed: OpenCV at the edge, a table of perfect
/// tracks, a synthetic scene in tests. Stateful only in caches (image pyramids, reference patches).
class FeatureTracker {
 public:
  virtual ~FeatureTracker() = default;
  /// Features of the first frame. @param organ_mask 8-bit mask of the registered organ's projection
  /// (non-zero = organ)
  /// @param wanted number of features to aim for
  virtual FeatureSet Detect(const Frame& frame, const Image& organ_mask, int wanted) = 0;
  /// Positions and states of `features` in `frame`, which follows the frame of the last call.
  virtual void Track(const Frame& frame, FeatureSet* features) = 0;
  /// A hint for the next call of Track: where the model expects each feature (same rows; NaN where
  /// it does not know). Used to find features again that were lost or hidden, never as a
  /// measurement.
  virtual void Predict(const Pixels& predicted_px) {}
};

/// Where the organ is seen in a frame, from the frame's own appearance.
class OrganSegmenter {
 public:
  virtual ~OrganSegmenter() = default;
  static constexpr std::uint8_t kOrgan = 255, kGround = 0;
  /// Behind an instrument: organ or not, nobody knows.
  static constexpr std::uint8_t kHidden = 128;
  /// @param model_mask projection of the registered model, 1 channel: where to start from
  /// @return 1 channel, size of the frame: kOrgan, kGround or kHidden; an empty image where it
  /// cannot be told
  virtual Image Segment(const Frame& frame, const Image& model_mask) = 0;
};

}  // namespace kerf
