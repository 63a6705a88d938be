#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <set>
#include <stdexcept>
#include <thread>

#include "Pipelines/SideBySide.h"

namespace kerf {
namespace {

class Heard : public Progress {
 public:
  void Report(double fraction, const std::string&) override {
    inside += 1;
    EXPECT_EQ(inside, 1) << "one thread at a time";
    EXPECT_GE(fraction, last - 1e-12);
    last = fraction;
    inside -= 1;
  }
  bool IsCancelled() const override { return cancelled; }
  std::atomic<int> inside = 0;
  double last = 0;
  std::atomic<bool> cancelled = false;
};

TEST(SideBySide, EveryJobRunsOnceAndNoMoreThanWantedAtATime) {
  for (const int jobs : {1, 2, 5}) {
    Heard heard;
    std::vector<std::atomic<int>> ran(9);
    std::atomic<int> now = 0, most = 0;
    RunSideBySide(
        9, jobs,
        [&](int i, Progress& progress) {
          int here = ++now, seen = most;
          while (here > seen && !most.compare_exchange_weak(seen, here)) {
          }
          for (int k = 0; k <= 10; ++k) progress.Report(k / 10.0, "");
          std::this_thread::sleep_for(std::chrono::milliseconds(2));
          ++ran[i];
          --now;
        },
        heard);
    for (const auto& count : ran) EXPECT_EQ(count, 1);
    EXPECT_LE(most, jobs);
    EXPECT_NEAR(heard.last, 1.0, 1e-12);
  }
}

TEST(SideBySide, AFailureEndsTheOthersAndIsThrown) {
  Heard heard;
  std::atomic<int> begun = 0, cancelled = 0;
  const auto run = [&] {
    RunSideBySide(
        50, 2,
        [&](int i, Progress& progress) {
          ++begun;
          if (i == 1) throw std::runtime_error("broken");
          for (int k = 0; k < 5000 && !progress.IsCancelled(); ++k)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
          cancelled += progress.IsCancelled();
        },
        heard);
  };
  EXPECT_THROW(run(), std::runtime_error);
  EXPECT_EQ(begun, 2) << "nothing is begun any more";
  EXPECT_EQ(cancelled, 1);
}

TEST(SideBySide, CancellingReachesEveryJob) {
  Heard heard;
  heard.cancelled = true;
  std::atomic<int> begun = 0;
  EXPECT_THROW(RunSideBySide(
                   7, 3,
                   [&](int, Progress& progress) {
                     ++begun;
                     progress.ThrowIfCancelled();
                   },
                   heard),
               Cancelled);
  EXPECT_LE(begun, 3);
}

}  // namespace
}  // namespace kerf
