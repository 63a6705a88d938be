#pragma once

#include <signal.h>
#include <sys/resource.h>
#include <time.h>

#include <QApplication>
#include <QElapsedTimer>
#include <QEvent>
#include <QMetaEnum>
#include <QThread>
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

  MeteredApplication(int& argc, char** argv) : QApplication(argc, argv) {
    signal(SIGCONT, [](int) { Continued() = 1; });
  }
  ~MeteredApplication() override {
    std::sort(slow_.begin(), slow_.end(),
              [](const Slow& a, const Slow& b) { return a.cpu_ms > b.cpu_ms; });
    for (const Slow& slow : slow_)
      std::printf(
          "held up: %5.0f ms (%5.0f ms of processor, %.0f ms waiting for one, %ld pages read from "
          "disk) by %s%s\n",
          slow.ms, slow.cpu_ms, slow.queued_ms, slow.from_disk, slow.what.c_str(),
          slow.during.c_str());
  }

  /// What is being done, for the list.
  static void Doing(const std::string& what) { Now() = what.empty() ? what : " while " + what; }

  bool notify(QObject* receiver, QEvent* event) override {
    // Inside another event, unless that one has opened a dialog with a loop of its own.
    if (running_ && running_->loop == thread()->loopLevel())
      return QApplication::notify(receiver, event);
    Running now;
    now.outer = running_;
    now.loop = thread()->loopLevel();
    if (running_) running_->Leave();
    running_ = &now;
    const std::string what = Name(receiver) + ", " + Kind(event);
    std::string during = Now();
    Continued() = 0;
    now.Go();
    const bool done = QApplication::notify(receiver, event);
    now.Pause();
    running_ = now.outer;
    // Somebody held the whole process: a pause that no code of it knows of.
    if (Continued()) during += ", when the process was stopped from outside";
    if (now.ms >= kNoted_ms || now.cpu_ms >= kNotedProcessor_ms)
      slow_.push_back({now.ms, now.cpu_ms, now.queued_ms, now.from_disk, what, during});
    if (running_) running_->Go();
    return done;
  }

 private:
  struct Slow {
    double ms, cpu_ms, queued_ms;
    long from_disk;
    std::string what, during;
  };
  /// An event that is being handled. The time in which a dialog that it opened handles others, or
  /// waits for them, is not its own.
  struct Running {
    Running* outer = nullptr;
    int loop = 0;
    double ms = 0, cpu_ms = 0, queued_ms = 0;
    long from_disk = 0;  ///< pages
    QElapsedTimer clock;
    double cpu_before = 0, queued_before = 0;
    long disk_before = 0;
    bool dialog = false;
    void Leave() {
      dialog ? clock.invalidate() : Pause();
      dialog = true;
    }
    void Go() {
      clock.start();
      cpu_before = Processor_ms();
      queued_before = Queued_ms();
      disk_before = FromDisk();
    }
    void Pause() {
      if (!clock.isValid()) return;
      ms += 1e-6 * static_cast<double>(clock.nsecsElapsed());
      cpu_ms += Processor_ms() - cpu_before;
      queued_ms += Queued_ms() - queued_before;
      from_disk += FromDisk() - disk_before;
      clock.invalidate();
    }
  };
  static volatile sig_atomic_t& Continued() {
    static volatile sig_atomic_t continued = 0;
    return continued;
  }
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
  /// Time in which this thread could run and had no core.
  static double Queued_ms() {
    double running_ns = 0, queued_ns = 0;
    if (std::FILE* file = std::fopen("/proc/thread-self/schedstat", "r")) {
      if (std::fscanf(file, "%lf %lf", &running_ns, &queued_ns) != 2) queued_ns = 0;
      std::fclose(file);
    }
    return 1e-6 * queued_ns;
  }
  /// Pages of this thread that were not in memory when it needed them.
  static long FromDisk() {
    rusage used{};
    getrusage(RUSAGE_THREAD, &used);
    return used.ru_majflt;
  }
  static std::string Name(const QObject* object) {
    std::string name = object->metaObject()->className();
    if (!object->objectName().isEmpty()) name += " " + object->objectName().toStdString();
    return name;
  }

  Running* running_ = nullptr;
  std::vector<Slow> slow_;
};

}  // namespace kerf::testing
