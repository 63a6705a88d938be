#pragma once

#include <fstream>
#include <string>

namespace kerf {

/// A file that appears under its name only when it is complete: written beside it under a temporary
/// name, synced and renamed by Commit(). Destroyed without Commit(), it leaves nothing behind and
/// an older file of that name untouched.
class AtomicFile {
 public:
  /// Creates missing parent folders. @throws InputError naming `path` when it cannot be written
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  std::ostream& Stream() { return stream_; }
  /// @throws InputError naming `path` and the system's reason: a full disk, a folder that is gone
  void Commit();

 private:
  std::string path_, temporary_;
  std::ofstream stream_;
  bool committed_ = false;
};

/// Writes to an open file and through to the system. @throws InputError naming `path`, with the
/// system's reason (a full disk, a folder that is gone) where it gives one
void WriteThrough(std::ofstream* stream, const std::string& path, const std::string& text);

/// For writers of other libraries, which want a name: a name beside `path` with the same extension.
std::string TemporaryNameBeside(const std::string& path);
/// Renames `temporary` (written by another library) to `path`, after syncing it. @throws InputError
void CommitTemporary(const std::string& temporary, const std::string& path);

}  // namespace kerf
