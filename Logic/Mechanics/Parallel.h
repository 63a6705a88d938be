#pragma once

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// Threads of one solver. Work is cut into chunks whose bounds depend on the problem alone, and
/// sums are taken over chunks in order, so results are the same bits for every thread count.
class Workers {
 public:
  /// @param threads 0 = those that the caller works with. No arena of its own then: threads take
  /// a while to move from one arena to another, and a frame's other work lies in the caller's.
  void Use(int threads) {
    if (threads == threads_) return;
    threads_ = threads;
    arena_ = threads > 1 ? std::make_unique<tbb::task_arena>(threads) : nullptr;
  }

  /// Runs all of a piece of work among these threads. An arena of their own stays at hand between
  /// its loops.
  template <class Function>
  void Run(const Function& function) const {
    if (arena_)
      arena_->execute(function);
    else
      function();
  }

  /// Two pieces of work that have nothing in common.
  template <class First, class Second>
  void Both(const First& first, const Second& second) const {
    if (threads_ == 1) {
      first();
      second();
      return;
    }
    Run([&] { tbb::parallel_invoke(first, second); });
  }

  /// function(begin, end) for each chunk of [0, count).
  template <class Function>
  void ForChunks(Index count, Index chunk, const Function& function) const {
    const Index chunks = (count + chunk - 1) / chunk;
    auto run = [&](Index c) { function(c * chunk, std::min(count, (c + 1) * chunk)); };
    if (threads_ == 1 || chunks <= 1) {
      for (Index c = 0; c < chunks; ++c) run(c);
      return;
    }
    Run([&] { tbb::parallel_for(Index{0}, chunks, run); });
  }

  /// Ordered sum of function(begin, end) over chunks of [0, count).
  template <class Function>
  double SumChunks(Index count, Index chunk, const Function& function) const {
    std::vector<double> part((count + chunk - 1) / chunk, 0.0);
    ForChunks(count, chunk,
              [&](Index begin, Index end) { part[begin / chunk] = function(begin, end); });
    double sum = 0.0;
    for (double p : part) sum += p;
    return sum;
  }

 private:
  int threads_ = 1;
  std::unique_ptr<tbb::task_arena> arena_;
};

}  // namespace kerf
