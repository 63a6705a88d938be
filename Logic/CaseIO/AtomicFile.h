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
  /// @throws InputError naming `path` and the system's reason: a full disk, a folder that is gone;
  /// also where it was a write long before this that failed
  void Commit();

 private:
  /// Keeps why the first write failed: by the time of Commit() errno may be of anything.
  class Buffer : public std::filebuf {
   public:
    int FirstError() const { return first_error_; }
    bool Close();  ///< @return false where not all was written

   protected:
    int_type overflow(int_type c) override;
    std::streamsize xsputn(const char* text, std::streamsize count) override;
    int sync() override;

   private:
    void Note(bool failed);
    int first_error_ = 0;
  };
  std::string path_, temporary_;
  Buffer buffer_;
  std::ostream stream_;
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
