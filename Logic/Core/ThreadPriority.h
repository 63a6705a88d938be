#pragma once

namespace kerf {

/// The calling thread, and the threads that it starts, get a third of what they would get of a core
/// that they share with others: work that must not hold up what somebody looks at. With more than
/// one step a third of that, and so on. Five steps of niceness each below what the thread has now;
/// where the system does not allow it, nothing changes.
void StepBehindOthers(int steps = 1);

}  // namespace kerf
