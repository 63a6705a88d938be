#include "StartWorkers.h"

#include <tbb/parallel_for.h>

#include <chrono>
#include <thread>

void StartWorkers() {
  tbb::parallel_for(0, 64,
                    [](int) { std::this_thread::sleep_for(std::chrono::microseconds(200)); });
}
