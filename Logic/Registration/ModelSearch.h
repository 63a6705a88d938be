#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "Registration/ModelProbe.h"

namespace kerf {

/// Searches for better cuts (Registration/ModelProbe.h) on a thread of its own, beside the frames
/// and behind them: it works where a core has nothing else to do; on a machine that leaves it too
/// little for half a second it is begun again as one among others (ten steps of niceness). It works
/// on a copy of the state; who began it says in which frame its answer is taken over, so that
/// results do not depend on how long it takes. One answer at a time.
class ModelSearch {
 public:
  ~ModelSearch() { Drop(); }  // and waits until all have noticed
  /// @return false where there is nothing to search for
  bool Begin(const std::vector<char>& usable, const CameraModel& camera,
             const MethodOptions& options, const RegistrationState& state);
  /// Whether Finish would not wait.
  bool Ready() const {
    return !found_.valid() || found_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  /// Waits for the end. @return none also when no search was begun
  std::optional<BetterModel> Finish();
  /// Gives a running search up: the cuts are no longer those that it began with. It notices after
  /// its present equilibrium or cut; only the destructor waits for that.
  void Drop();

  using Result = std::future<std::optional<BetterModel>>;
  struct Answer {
    std::optional<BetterModel> better;
    Result left_behind;  ///< a thread that got no core, and has still to notice that it may end
  };
  /// `search` on an idle thread, or again on this one; for the thread of a search.
  static Answer BehindOthers(
      const std::function<std::optional<BetterModel>(const std::atomic<bool>*)>& search,
      const std::atomic<bool>& given_up);

 private:
  /// Forgets those that have noticed.
  void Clear();
  std::future<Answer> found_;
  std::shared_ptr<std::atomic<bool>> given_up_;
  std::vector<std::future<Answer>> given_up_ones_;  ///< that may still run
  std::vector<Result> left_behind_;
};

/// What a search found, put into the state of some frames later: the organ has moved since, and its
/// cuts may have grown. A cut whose end has grown meanwhile stays as it is.
CutEvent TakeOver(BetterModel better, const MethodOptions& options, Engine& engine,
                  RegistrationState* state);

}  // namespace kerf
