#include "Core/ThreadPriority.h"

#ifdef __linux__
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace kerf {

void StepBehindOthers(int steps) {
#ifdef __linux__
  constexpr int kNiceness = 5;
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + steps * kNiceness);
#endif
}

}  // namespace kerf
