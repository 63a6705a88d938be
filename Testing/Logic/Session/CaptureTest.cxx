// The capture thread: newest frame only, silence noticed, losses mended.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "Core/Errors.h"
#include "Session/IntraoperativeCapture.h"
#include "Support/HeldClock.h"

namespace kerf {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

std::shared_ptr<const Image> Picture(int shade) {
  auto image = std::make_shared<Image>();
  image->width = 8;
  image->height = 4;
  image->data.assign(8 * 4 * 3, std::uint8_t(shade));
  return image;
}

/// What the source does is told by the test.
struct Script {
  std::atomic<int> opened{0}, read{0};
  std::atomic<bool> freeze{false}, hang{false}, end{false}, refuse{false};
};

class ScriptedSource : public FrameSource {
 public:
  ScriptedSource(std::shared_ptr<Script> script, int count, double fps)
      : script_(std::move(script)), count_(count), fps_(fps) {}
  std::optional<Frame> Next() override {
    while (script_->hang) std::this_thread::sleep_for(5ms);
    if (count_ < 0) std::this_thread::sleep_for(10ms);
    if (script_->end || (count_ >= 0 && next_ >= count_)) return std::nullopt;
    Frame frame;
    frame.index = next_++;
    frame.image = Picture(script_->freeze ? 7 : frame.index % 250 + 1);
    ++script_->read;
    return frame;
  }
  int Width() const override { return 8; }
  int Height() const override { return 4; }
  double FramesPerSecond() const override { return fps_; }
  int FrameCount() const override { return count_; }

 private:
  std::shared_ptr<Script> script_;
  int count_, next_ = 0;
  double fps_;
};

IntraoperativeCapture::Opener OpenerOf(std::shared_ptr<Script> script, int count, double fps = 50) {
  return [=]() -> std::unique_ptr<FrameSource> {
    if (script->refuse) throw InputError("camera", "", "is not there");
    ++script->opened;
    return std::make_unique<ScriptedSource>(script, count, fps);
  };
}

template <class F>
double SecondsUntil(F condition, double most_s = 3.0) {
  const auto start = Clock::now();
  while (!condition()) {
    const double passed = std::chrono::duration<double>(Clock::now() - start).count();
    if (passed > most_s) return 1e9;
    std::this_thread::sleep_for(2ms);
  }
  return std::chrono::duration<double>(Clock::now() - start).count();
}

using Kind = SourceState::Kind;

TEST(Capture, EveryFrameInOrderWhenNoneMayBeDropped) {
  CaptureOptions options;
  options.every = true;
  options.paced = false;
  IntraoperativeCapture capture(OpenerOf(std::make_shared<Script>(), 40), options);
  for (int i = 0; i < 40; ++i) {
    const auto frame = capture.Take(2.0);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->frame.index, i);
  }
  EXPECT_FALSE(capture.Take(1.0));
  EXPECT_EQ(capture.State().kind, Kind::Ended);
  EXPECT_EQ(capture.State().dropped, 0);
}

TEST(Capture, ASlowTakerGetsTheNewestAndDropsAreCounted) {
  IntraoperativeCapture capture(OpenerOf(std::make_shared<Script>(), 25, 100), {});
  ASSERT_TRUE(capture.Take(2.0));
  SecondsUntil([&] { return capture.State().kind == Kind::Ended; });
  const auto last = capture.Take(0.1);
  ASSERT_TRUE(last);
  EXPECT_EQ(last->frame.index, 24);
  EXPECT_GT(capture.State().dropped, 15);
  EXPECT_FALSE(capture.Take(0.05));  // never the same one twice
}

TEST(Capture, AFileHoldsDuringExposure) {
  CaptureOptions options;
  options.hold = true;
  auto script = std::make_shared<Script>();
  IntraoperativeCapture capture(OpenerOf(script, 10), options);
  SecondsUntil([&] { return capture.Newest().has_value(); });
  std::this_thread::sleep_for(600ms);
  EXPECT_EQ(script->read, 1);
  EXPECT_EQ(capture.State().kind, Kind::Running);  // it waits on purpose
  capture.Resume();
  EXPECT_LT(SecondsUntil([&] { return script->read == 10; }), 2.0);
}

TEST(Capture, ARepeatedPictureIsFrozenWithinHalfASecond) {
  testing::HeldClock clock;
  CaptureOptions options;
  options.live = true;
  options.clock = clock;
  auto script = std::make_shared<Script>();
  IntraoperativeCapture capture(OpenerOf(script, -1), options);
  ASSERT_TRUE(capture.Take(2.0));
  clock.HoldSince([&] { return capture.State(); }, 0.0);
  script->freeze = true;
  const int read = script->read;
  ASSERT_LT(SecondsUntil([&] { return script->read > read + 3; }), 10.0);
  clock.HoldSince([&] { return capture.State(); }, 0.3);
  EXPECT_EQ(capture.State().kind, Kind::Running);
  clock.HoldSince([&] { return capture.State(); }, 0.5 - 1e-3);
  EXPECT_EQ(capture.State().kind, Kind::Frozen);
  EXPECT_EQ(capture.State().message, "The picture has been frozen for 0.4 s.");
  script->freeze = false;
  EXPECT_LT(SecondsUntil([&] { return capture.State().kind == Kind::Running; }, 10.0), 10.0);
}

TEST(Capture, AHangingDeviceIsFrozenAndNobodyWaitsForIt) {
  testing::HeldClock clock;
  CaptureOptions options;
  options.live = true;
  options.clock = clock;
  auto script = std::make_shared<Script>();
  {
    IntraoperativeCapture capture(OpenerOf(script, -1), options);
    ASSERT_TRUE(capture.Take(2.0));
    clock.HoldSince([&] { return capture.State(); }, 0.0);
    script->hang = true;
    std::this_thread::sleep_for(100ms);  // what is being read still comes
    clock.HoldSince([&] { return capture.State(); }, 0.3);
    EXPECT_EQ(capture.State().kind, Kind::Running);
    clock.HoldSince([&] { return capture.State(); }, 0.5);
    EXPECT_EQ(capture.State().kind, Kind::Frozen);
  }  // returns although the read does not
  script->hang = false;
}

TEST(Capture, ALostSourceIsSaidAndReconnected) {
  CaptureOptions options;
  options.live = true;
  auto script = std::make_shared<Script>();
  IntraoperativeCapture capture(OpenerOf(script, -1), options);
  ASSERT_TRUE(capture.Take(2.0));
  script->refuse = true;
  script->end = true;
  EXPECT_LT(SecondsUntil([&] { return capture.State().kind == Kind::Lost; }), 0.5);
  EXPECT_LT(SecondsUntil(
                [&] { return capture.State().message.find("is not there") != std::string::npos; }),
            1.0);
  script->end = false;
  script->refuse = false;
  EXPECT_LT(SecondsUntil([&] { return capture.State().kind == Kind::Running; }), 1.0);
  EXPECT_EQ(capture.State().reconnects, 1);
  ASSERT_TRUE(capture.Take(1.0));
}

TEST(Capture, AFileThatBreaksOffIsLostNotEnded) {
  auto script = std::make_shared<Script>();
  CaptureOptions options;
  options.paced = false;
  IntraoperativeCapture capture(OpenerOf(script, 1000000), options);
  ASSERT_TRUE(capture.Take(2.0));
  script->end = true;
  EXPECT_LT(SecondsUntil([&] { return capture.State().kind == Kind::Lost; }), 1.0);
}

}  // namespace
}  // namespace kerf
