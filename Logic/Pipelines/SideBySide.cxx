#include "Pipelines/SideBySide.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <numeric>
#include <system_error>
#include <thread>
#include <vector>

namespace kerf {
namespace {

/// What the jobs share.
struct Board {
  Board(Progress& whole, int count) : whole(whole), fraction(count, 0.0) {}
  Progress& whole;
  mutable std::mutex mutex;
  std::vector<double> fraction;  ///< of each job
  std::exception_ptr error;
  int next = 0;
};

class Share : public Progress {
 public:
  Share(Board& board, int job) : board_(board), job_(job) {}
  void Report(double fraction, const std::string& what) override {
    const std::lock_guard lock(board_.mutex);
    board_.fraction[job_] = fraction;
    const double sum = std::accumulate(board_.fraction.begin(), board_.fraction.end(), 0.0);
    board_.whole.Report(sum / static_cast<double>(board_.fraction.size()), what);
  }
  void Warn(const std::string& message) override {
    const std::lock_guard lock(board_.mutex);
    board_.whole.Warn(message);
  }
  bool IsCancelled() const override {
    const std::lock_guard lock(board_.mutex);
    return board_.error || board_.whole.IsCancelled();
  }

 private:
  Board& board_;
  int job_;
};

}  // namespace

void RunSideBySide(int count, int jobs, const std::function<void(int, Progress&)>& job,
                   Progress& progress) {
  Board board(progress, count);
  const auto work = [&] {
    while (true) {
      int mine = 0;
      {
        const std::lock_guard lock(board.mutex);
        if (board.error || board.next == count) return;
        mine = board.next++;
      }
      try {
        Share share(board, mine);
        job(mine, share);
        share.Report(1.0, "done");
      } catch (...) {
        const std::lock_guard lock(board.mutex);
        if (!board.error) board.error = std::current_exception();
      }
    }
  };
  std::vector<std::thread> others;
  try {
    for (int i = 1; i < std::min(jobs, count); ++i) others.emplace_back(work);
  } catch (const std::system_error&) {  // no more threads to be had: those there are do it
  }
  work();
  for (std::thread& thread : others) thread.join();
  if (board.error) std::rethrow_exception(board.error);
}

}  // namespace kerf
