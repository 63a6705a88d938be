#pragma once

#include <string>
#include <utility>

#include "Core/Errors.h"

namespace kerf {

/// Where long work reports to and asks whether it is still wanted. Implementations: a line in the
/// shell, the window's progress bar, the silent default. Called from the working thread.
class Progress {
 public:
  virtual ~Progress() = default;
  /// @param fraction of the whole job, 0..1; @param what a short phrase for people ("meshing
  /// organ")
  virtual void Report(double fraction, const std::string& what) {}
  /// A sentence worth keeping: a warning, an assumption that was made.
  virtual void Warn(const std::string& message) {}
  virtual bool IsCancelled() const { return false; }
  /// @throws Cancelled when the user does not want the work any more
  void ThrowIfCancelled() const {
    if (IsCancelled()) throw Cancelled();
  }
};

/// Maps the 0..1 of a part of a job into [begin, end] of the whole; `of` stands before its phrases
/// and warnings.
class SubProgress : public Progress {
 public:
  SubProgress(Progress& parent, double begin, double end, std::string of = "")
      : parent_(parent), begin_(begin), end_(end), of_(std::move(of)) {}
  void Report(double fraction, const std::string& what) override {
    parent_.Report(begin_ + (end_ - begin_) * fraction, of_.empty() ? what : of_ + what);
  }
  void Warn(const std::string& message) override { parent_.Warn(of_ + message); }
  bool IsCancelled() const override { return parent_.IsCancelled(); }

 private:
  Progress& parent_;
  double begin_, end_;
  std::string of_;
};

}  // namespace kerf
