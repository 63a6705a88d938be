#include "Session/UndoStack.h"

#include <utility>

namespace kerf {

UndoStack::UndoStack(std::size_t limit_bytes) : limit_bytes_(limit_bytes) {}

void UndoStack::Push(UndoCommand command) {
  for (const UndoCommand& c : undone_) bytes_ -= c.bytes;
  undone_.clear();
  bytes_ += command.bytes;
  done_.push_back(std::move(command));
  // The newest step always stays, however large.
  while (bytes_ > limit_bytes_ && done_.size() > 1) {
    bytes_ -= done_.front().bytes;
    done_.pop_front();
  }
  Changed();
}

bool UndoStack::Undo() {
  if (done_.empty()) return false;
  UndoCommand command = std::move(done_.back());
  done_.pop_back();
  command.undo();
  undone_.push_back(std::move(command));
  Changed();
  return true;
}

bool UndoStack::Redo() {
  if (undone_.empty()) return false;
  UndoCommand command = std::move(undone_.back());
  undone_.pop_back();
  command.redo();
  done_.push_back(std::move(command));
  Changed();
  return true;
}

void UndoStack::Clear() {
  done_.clear();
  undone_.clear();
  bytes_ = 0;
  Changed();
}

void UndoStack::Changed() const {
  if (listener_) listener_();
}

}  // namespace kerf
