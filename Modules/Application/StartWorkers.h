#pragma once

/// Starts the threads of parallel loops. They start with the first loop and inherit the priority of
/// who runs it: that must not be a job, which steps behind the window.
void StartWorkers();
