#pragma once

#include <deque>
#include <memory>

#include "Core/Frame.h"
#include "Registration/Reliability.h"

namespace kerf {

/// What a single frame's residuals do not show: a source that repeats its last picture, a camera
/// that moved, too few pictures to see a cut grow. Looks at the pictures' time stamps only, so a
/// replay says the same. Where several things are wrong the first is named: registration's own
/// reason, else that of the first call.
class FrameWatch {
 public:
  void WatchPicture(const Frame& frame, Reliability* reliability);
  /// @param leap_mm median step of the tracked features since the last frame
  void WatchLeap(double time_s, double leap_mm, Reliability* reliability);
  /// Once for each picture that is registered; those between that were passed over do not count.
  void WatchRate(double time_s, Reliability* reliability);

 private:
  std::shared_ptr<const Image> picture_;  ///< of the last frame
  double changed_s_ = 0.0;                ///< when it was last another
  double last_s_ = -1.0, leapt_s_ = -1.0;
  std::deque<double> registered_s_;  ///< time stamps of the last pictures
  double sparse_s_ = -1.0;           ///< when they were last too far apart
  double sparse_rate_ = 0.0;         ///< then, pictures a second
};

}  // namespace kerf
