#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "Core/Frame.h"

namespace kerf {

/// What a live source is doing, for people.
struct SourceState {
  enum class Kind { Opening, Running, Frozen, Lost, Ended } kind = Kind::Opening;
  std::string message;  ///< a sentence, empty while it runs
  int width = 0, height = 0;
  double nominal_fps = 0.0;
  double fps = 0.0;  ///< of the last second
  int delivered = 0;
  int dropped = 0;  ///< replaced by a newer one before anybody took them
  int reconnects = 0;
  double silence_s = 0.0;  ///< since the last new picture
  bool Usable() const { return kind == Kind::Running || kind == Kind::Ended; }
};

struct CapturedFrame {
  Frame frame;  ///< numbered as the source counts, on and on over reconnections
  std::chrono::steady_clock::time_point captured;
};

struct CaptureOptions {
  bool live = false;   ///< device or stream: reconnected when it is lost; a file just ends
  bool paced = true;   ///< a file delivers at its own rate
  bool every = false;  ///< wait until a frame is taken: no drops (tests, soak)
  bool hold = false;   ///< stop after the first frame until Resume(): a file during exposure
  double frozen_after_s = 0.4;
  double retry_after_s = 0.25;
  /// What stamps the pictures, and what silence and waiting for the registration are measured by.
  std::function<std::chrono::steady_clock::time_point()> clock = std::chrono::steady_clock::now;
};

/// The capture thread: reads a source and keeps the newest frame only. Frozen means that the same
/// picture comes again and again, or none at all. Safe to use from several threads.
class IntraoperativeCapture {
 public:
  using Opener = std::function<std::unique_ptr<FrameSource>()>;
  /// Opens in the background; `open` is called again after a loss.
  IntraoperativeCapture(Opener open, const CaptureOptions& options);
  ~IntraoperativeCapture();  ///< never waits for a device that hangs
  IntraoperativeCapture(const IntraoperativeCapture&) = delete;
  IntraoperativeCapture& operator=(const IntraoperativeCapture&) = delete;

  /// The newest frame that nobody took yet; waits for it. None after `timeout_s`.
  std::optional<CapturedFrame> Take(double timeout_s);
  /// The newest frame of all, without taking it.
  std::optional<CapturedFrame> Newest() const;
  /// When the first of the frames after the one of `captured` came; none where that is the newest,
  /// or where every frame is waited for: then none is late.
  std::optional<std::chrono::steady_clock::time_point> FirstAfter(
      std::chrono::steady_clock::time_point captured) const;
  /// By the clock that the frames are stamped with.
  std::chrono::steady_clock::time_point Now() const;
  void Resume();
  SourceState State() const;

 private:
  struct Shared;
  static void Run(std::shared_ptr<Shared> shared, Opener open);
  std::shared_ptr<Shared> shared_;
};

}  // namespace kerf
