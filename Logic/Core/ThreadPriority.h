#pragma once

#include <functional>

namespace kerf {

/// The calling thread, and the threads that it starts, get a third of what they would get of a core
/// that they share with others: work that must not hold up what somebody looks at. Five steps of
/// niceness below what the thread has now; where the system does not allow it, nothing changes.
void StepBehindOthers();

/// The calling thread, and the threads that it starts, work where a core has nothing else to do,
/// and leave it at once when it has (SCHED_IDLE: a lower niceness alone keeps a core for
/// milliseconds after another thread has woken). On a machine that others keep busy they hardly get
/// on.
void WorkWhenIdle();

/// A clock of the processor time that the calling thread has had, s, to be read by any thread while
/// this one runs; infinite where the system has none.
std::function<double()> ProcessorClock();

}  // namespace kerf
