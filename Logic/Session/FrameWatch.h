#pragma once

#include <memory>

#include "Core/Frame.h"
#include "Registration/Reliability.h"

namespace kerf {

/// What a single frame's residuals do not show: a source that repeats its last picture, a camera
/// that moved.
class FrameWatch {
 public:
  void WatchPicture(const Frame& frame, Reliability* reliability);
  /// @param leap_mm median step of the tracked features since the last frame
  void WatchLeap(double time_s, double leap_mm, Reliability* reliability);

 private:
  std::shared_ptr<const Image> picture_;  ///< of the last frame
  double changed_s_ = 0.0;                ///< when it was last another
  double last_s_ = -1.0, leapt_s_ = -1.0;
};

}  // namespace kerf
