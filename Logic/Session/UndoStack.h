#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <string>

namespace kerf {

/// A step that was already taken and can be taken back. `undo` and `redo` are exact inverses.
struct UndoCommand {
  std::string name;  ///< what a person did, without "undo": "grow liver"
  std::function<void()> undo, redo;
  std::size_t bytes = 0;  ///< that the closures keep alive; the oldest steps go when it is too much
};

/// The one undo/redo stack of the application. Not for use from several threads.
class UndoStack {
 public:
  explicit UndoStack(std::size_t limit_bytes = std::size_t(512) << 20);

  /// The step has been taken already. What could be redone is forgotten.
  void Push(UndoCommand command);
  /// @return false when there is nothing
  bool Undo();
  bool Redo();
  void Clear();

  bool CanUndo() const { return !done_.empty(); }
  bool CanRedo() const { return !undone_.empty(); }
  std::string UndoName() const { return done_.empty() ? "" : done_.back().name; }
  std::string RedoName() const { return undone_.empty() ? "" : undone_.back().name; }
  std::size_t Count() const { return done_.size(); }
  std::size_t Bytes() const { return bytes_; }
  /// Called after every change.
  void SetListener(std::function<void()> listener) { listener_ = std::move(listener); }

 private:
  void Changed() const;

  std::size_t limit_bytes_, bytes_ = 0;
  std::deque<UndoCommand> done_, undone_;
  std::function<void()> listener_;
};

}  // namespace kerf
