#include "Core/ThreadPriority.h"

#include <limits>

#ifdef __linux__
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
#endif

namespace kerf {

void StepBehindOthers() {
#ifdef __linux__
  constexpr int kNiceness = 5;
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + kNiceness);
#endif
}

void WorkWhenIdle() {
#ifdef __linux__
  const sched_param none{};
  sched_setscheduler(0, SCHED_IDLE, &none);  // 0: the calling thread
#endif
}

std::function<double()> ProcessorClock() {
#ifdef __linux__
  clockid_t clock;
  if (pthread_getcpuclockid(pthread_self(), &clock) == 0)
    return [clock] {
      timespec now{};
      return clock_gettime(clock, &now) == 0 ? double(now.tv_sec) + 1e-9 * double(now.tv_nsec)
                                             : std::numeric_limits<double>::infinity();
    };
#endif
  return [] { return std::numeric_limits<double>::infinity(); };
}

}  // namespace kerf
