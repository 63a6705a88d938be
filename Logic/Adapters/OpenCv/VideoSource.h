#pragma once

#include <memory>
#include <string>

#include "Core/Frame.h"

namespace kerf {

struct VideoOptions {
  double frames_per_second = 0.0;  ///< of an image sequence; 0: 25. A file knows its own.
  int minimum_frames = 2;  ///< fewer readable frames are an InputError: one frame cannot be tracked
};

/// A recorded video (through FFmpeg), an image sequence, a capture device or a network stream.
/// Frames are BGR, raw (distorted), numbered from 0; time = number / frame rate.
class VideoSource : public FrameSource {
 public:
  /// True when the source ended before its announced end: what was delivered is good, the rest is
  /// missing.
  bool Broken() const { return !break_report_.empty(); }
  /// A sentence that names the source and the first missing frame; empty unless Broken().
  const std::string& BreakReport() const { return break_report_; }
  /// Goes to a frame, so that Next() reads it. @return false where the source cannot be placed; it
  /// is where it was then
  virtual bool GoTo(int index) = 0;

 protected:
  std::string break_report_;
};

/// Opens a video file, a folder of images (in natural order of their names), a printf pattern such
/// as `frames/%05d.png`, a device (`/dev/video0`) or a URL (`rtsp://…`).
/// @throws InputError naming the file and the frame: missing, empty, nothing readable, fewer frames
/// than wanted; a network stream that does not answer within 6 s. It ends after 2 s of silence.
///   `Next` throws it when the size changes from one frame to the next
std::unique_ptr<VideoSource> OpenVideo(const std::string& path, const VideoOptions& options = {});

/// FFmpeg's own complaints go to stderr without a file name; ours name file and frame. Sets an
/// environment variable the first time: call it before there are threads that open videos.
void SilenceFfmpeg();

}  // namespace kerf
