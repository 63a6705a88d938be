#pragma once

#include <time.h>

#include <QApplication>
#include <QElapsedTimer>
#include <QEvent>
#include <QMetaEnum>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace kerf::testing {

/// An application that notes which events held the window up, and says so at its end: the window is
/// to answer within 100 ms, and long work belongs into jobs. Noted is what took 50 ms of the window
/// thread's own processor time, or 100 ms with what others did meanwhile. Not a limit that a test
/// fails on: other programs on the machine take time, too.
class MeteredApplication : public QApplication {
 public:
  static constexpr double kNoted_ms = 100, kNotedProcessor_ms = 50;

  using QApplication::QApplication;
  ~MeteredApplication() override {
    std::sort(slow_.begin(), slow_.end(),
              [](const Slow& a, const Slow& b) { return a.cpu_ms > b.cpu_ms; });
    for (const Slow& slow : slow_)
      std::printf("held up: %5.0f ms (%5.0f ms of processor) by %s%s\n", slow.ms, slow.cpu_ms,
                  slow.what.c_str(), slow.during.c_str());
  }

  /// What is being done, for the list.
  static void Doing(const std::string& what) { Now() = what.empty() ? what : " while " + what; }

  bool notify(QObject* receiver, QEvent* event) override {
    if (depth_ > 0) return QApplication::notify(receiver, event);
    const std::string what = Name(receiver) + ", " + Kind(event);
    const std::string during = Now();
    QElapsedTimer clock;
    clock.start();
    const double cpu_before = Processor_ms();
    ++depth_;
    const bool done = QApplication::notify(receiver, event);
    --depth_;
    const double ms = 1e-6 * static_cast<double>(clock.nsecsElapsed());
    const double cpu_ms = Processor_ms() - cpu_before;
    if (ms >= kNoted_ms || cpu_ms >= kNotedProcessor_ms)
      slow_.push_back({ms, cpu_ms, what, during});
    return done;
  }

 private:
  struct Slow {
    double ms, cpu_ms;
    std::string what, during;
  };
  static std::string& Now() {
    static std::string now;
    return now;
  }
  static std::string Kind(const QEvent* event) {
    const char* name = QMetaEnum::fromType<QEvent::Type>().valueToKey(event->type());
    return name ? name : "event " + std::to_string(event->type());
  }
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
