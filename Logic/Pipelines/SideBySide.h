#pragma once
// Private to Pipelines: jobs that run beside each other under one progress.

#include <functional>

#include "Core/Progress.h"

namespace kerf {

/// Runs job(0) … job(count − 1), at most `jobs` at a time, begun in this order. Each gets a
/// progress of its own, safe in its thread; `progress` sees their mean and is called by one thread
/// at a time. The first exception stops those that have not begun, is passed on as a cancellation
/// to those that have, and thrown again when all have ended.
void RunSideBySide(int count, int jobs, const std::function<void(int, Progress&)>& job,
                   Progress& progress);

}  // namespace kerf
