#pragma once

#include <memory>
#include <string>
#include <vector>

#include "Core/Camera.h"
#include "Pipelines/SessionFolder.h"
#include "Session/IntraoperativeSnapshot.h"

namespace kerf {

class SessionSource;

/// Something that happened in a session, for its timeline.
struct PlaybackEvent {
  enum class Kind { Cut, Decision, Mark, Loss } kind = Kind::Mark;
  int frame = 0;  ///< the first one that shows it
  double time_s = 0.0;
  std::string words;
};

/// A recorded session to look at: at any frame what the surgeon saw, with the states of
/// `kerf replay` (SessionRun). The session is done again once, in a thread of its own; what it gave
/// is kept in a scratch file, so that every frame reached so far is at hand at once. Used from one
/// thread.
class SessionPlayback {
 public:
  /// Reads session and case (about a second). @throws InputError naming file and element
  explicit SessionPlayback(const std::string& session_folder);
  ~SessionPlayback();
  SessionPlayback(const SessionPlayback&) = delete;
  SessionPlayback& operator=(const SessionPlayback&) = delete;

  const SessionFolder& Session() const;
  const CameraModel& Camera() const;
  const std::vector<PlaybackEvent>& Events() const;
  /// Frames that were registered; one more shows the last picture with what was decided after it,
  /// where something was.
  int FrameCount() const;
  double TimeOf_s(int frame) const;
  /// The frame that was to be seen at this time of the session.
  int FrameAt(double time_s) const;

  /// Frames that have been done again; those before it can be looked at.
  int Ready() const;
  /// Why it ends before FrameCount(); empty while all is well.
  std::string Problem() const;
  /// Picture and model of a frame before Ready(). @throws InputError naming the file
  std::shared_ptr<const IntraoperativeSnapshot> At(int frame);

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
  std::unique_ptr<SessionSource> pictures_;
};

}  // namespace kerf
