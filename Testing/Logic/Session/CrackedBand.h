#pragma once

#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <thread>

#include "Session/RegistrationSession.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

/// A band that is stretched and then cut from one edge on, seen by a perfect tracker: no pictures.
namespace kerf::testing {

constexpr double kCrackX_mm = 1.3;
constexpr int kRestFrames = 30, kCutFrames = 40;

inline CameraModel BandCamera() { return testing::PinholeAbove(960, 540, 900, 150); }

/// The field of a crack on top of a stretch: smooth but on the crack x = kCrackX_mm, whose tip runs
/// from the edge y = −20 into the band.
inline Vec3 CrackMotion(const Vec3& rest, int frame) {
  const double s = std::clamp((frame - kRestFrames) / double(kCutFrames), 0.0, 1.0);
  Vec3 p = rest;
  p.x() *= 1.0 + 0.05 * std::min(1.0, frame / double(kRestFrames)) + 0.05 * s;
  if (s <= 0) return p;
  const double tip = -20.0 + 25.0 * s, behind = tip - rest.y(), aside = rest.x() - kCrackX_mm;
  const double root = std::sqrt(0.5 * (std::hypot(behind, aside) + behind));
  p.x() += (aside > 0 ? 1.0 : -1.0) * 1.1 * s * std::exp(-std::abs(aside) / 40.0) * root;
  return p;
}

class CrackTracker : public FeatureTracker {
 public:
  FeatureSet Detect(const Frame&, const Image&, int) override {
    if (stuck) std::this_thread::sleep_for(stuck->detecting);
    FeatureSet features;
    std::vector<Vec3> rest;
    for (double y = -16; y <= 16; y += 4)
      for (double x = -54; x <= 54; x += 4.5)
        rest.push_back(Vec3(x + std::sin(7 * x + y), y + std::cos(5 * y + x), 5.0));
    rest_ = rest;
    features.pixels.resize(rest.size(), 2);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      features.id.push_back(int(i));
      features.pixels.row(i) = camera_.Project(rest[i]).transpose();
    }
    features.status.assign(rest.size(), FeatureStatus::Tracked);
    return features;
  }
  void Track(const Frame& frame, FeatureSet* features) override {
    while (stuck && stuck->here && stuck->passes == 0) {
      stuck->waits = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    if (stuck) stuck->waits = false;
    if (stuck && stuck->passes > 0) --stuck->passes;
    if (frame.index >= throw_at) throw std::runtime_error("the tracker broke");
    for (Index i = 0; i < features->Size(); ++i)
      features->pixels.row(i) =
          camera_.Project(CrackMotion(rest_[i], std::min(frame.index, stop_at))).transpose();
  }
  struct Stuck {
    std::atomic<bool> here{false};           ///< while it is set nothing comes out
    std::atomic<bool> waits{false};          ///< a frame is in it
    std::atomic<int> passes{0};              ///< so many come out all the same
    std::chrono::milliseconds detecting{0};  ///< how long that takes
  };
  int stop_at = 1 << 20;   ///< the motion halts here
  int throw_at = 1 << 20;  ///< from here on it cannot track any more
  std::shared_ptr<Stuck> stuck{};

 private:
  CameraModel camera_ = BandCamera();
  std::vector<Vec3> rest_;
};

/// A session over the band, with a handle on its tracker.
struct BandRun {
  explicit BandRun(bool history = true, bool hold = false, int stop_at = 1 << 20,
                   int throw_at = 1 << 20, bool grips = true,
                   std::shared_ptr<CrackTracker::Stuck> stuck = {}) {
    auto tracker = std::make_unique<CrackTracker>();
    tracker->stop_at = stop_at;
    tracker->throw_at = throw_at;
    tracker->stuck = std::move(stuck);
    MethodOptions options;
    options.hold_cuts = hold;
    options.grips = grips;
    session = std::make_unique<RegistrationSession>(BandMesh(3000), std::vector<Structure>(),
                                                    BandCamera(), options, std::move(tracker));
    if (history) session->KeepHistory();
  }
  SessionFrame Next() {
    Frame frame;
    frame.index = next++;
    frame.time_s = frame.index / 25.0;
    return session->Process(frame);
  }
  void RunTo(int frame) {
    while (next < frame) Next();
  }
  /// Runs until a cut was found. @return false when none was by `last`
  bool RunToCut(int last = kRestFrames + kCutFrames) {
    while (next <= last)
      if (!Next().step.cuts.empty()) return true;
    return false;
  }
  const RegistrationState& State() const { return session->State(); }
  std::unique_ptr<RegistrationSession> session;
  int next = 0;
};

/// A straight line across the band at x, beyond both edges.
inline Points AcrossBand(double x) {
  Points line(12, 3);
  for (int i = 0; i < 12; ++i) line.row(i) << x, -25.0 + 50.0 * i / 11, 5.0;
  return line;
}

}  // namespace kerf::testing
