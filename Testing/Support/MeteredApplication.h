#pragma once

#include <time.h>

#include <QApplication>
#include <QElapsedTimer>
#include <QEvent>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace kerf::testing {

/// An application that notes which events held the window up, and says so at its end: the window is
/// to answer within 100 ms, and long work belongs into jobs. Not a limit that a test fails on:
/// other programs on the machine take time, too. The processor's time is what the window itself
/// took.
class MeteredApplication : public QApplication {
 public:
  static constexpr int kNoted_ms = 100;

  using QApplication::QApplication;
  ~MeteredApplication() override {
    std::sort(slow_.begin(), slow_.end(), [](const Slow& a, const Slow& b) { return a.ms > b.ms; });
    for (const Slow& slow : slow_)
      std::printf("held up: %5.0f ms (%5.0f ms of processor) by %s\n", slow.ms, slow.cpu_ms,
                  slow.what.c_str());
  }

  bool notify(QObject* receiver, QEvent* event) override {
    if (depth_ > 0) return QApplication::notify(receiver, event);
    const std::string what = Name(receiver) + ", event " + std::to_string(event->type());
    QElapsedTimer clock;
    clock.start();
    const double cpu_before = Processor_ms();
    ++depth_;
    const bool done = QApplication::notify(receiver, event);
    --depth_;
    if (clock.elapsed() >= kNoted_ms)
      slow_.push_back({double(clock.elapsed()), Processor_ms() - cpu_before, what});
    return done;
  }

 private:
  struct Slow {
    double ms, cpu_ms;
    std::string what;
  };
  static double Processor_ms() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e3 * now.tv_sec + 1e-6 * now.tv_nsec;
  }
  static std::string Name(const QObject* object) {
    std::string name = object->metaObject()->className();
    if (!object->objectName().isEmpty()) name += " " + object->objectName().toStdString();
    return name;
  }

  int depth_ = 0;
  std::vector<Slow> slow_;
};

}  // namespace kerf::testing
