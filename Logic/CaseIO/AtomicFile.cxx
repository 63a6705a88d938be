#include "CaseIO/AtomicFile.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "Core/Errors.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

void MakeParent(const fs::path& path) {
  if (!path.has_parent_path()) return;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error)
    throw InputError(path.parent_path().string(), "", "cannot be created: " + error.message());
}

/// What a file system allocates late (NFS, a quota) fails only here. @return 0, or the reason
int Sync(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY);
  if (descriptor < 0) return errno;
  int problem = ::fsync(descriptor) == 0 ? 0 : errno;
  if (problem == EINVAL || problem == ENOSYS) problem = 0;  // it has no such thing
  ::close(descriptor);
  return problem;
}

/// The system's reason for what just failed. errno was set to 0 before: not every failure sets it.
std::string Because(const std::string& problem) {
  return errno != 0 ? problem + ": " + std::strerror(errno) : problem;
}

}  // namespace

std::string TemporaryNameBeside(const std::string& path) {
  const fs::path p(path);
  MakeParent(p);
  const std::string name = "." + std::to_string(::getpid()) + ".partial." + p.filename().string();
  return (p.parent_path() / name).string();
}

void CommitTemporary(const std::string& temporary, const std::string& path) {
  int problem = Sync(temporary);
  if (problem == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) problem = errno;
  if (problem == 0) return;
  std::remove(temporary.c_str());
  throw InputError(path, "", std::string("cannot be written: ") + std::strerror(problem));
}

void WriteThrough(std::ofstream* stream, const std::string& path, const std::string& text) {
  errno = 0;
  *stream << text << std::flush;
  if (!*stream) throw InputError(path, "", Because("cannot be written any more"));
}

void AtomicFile::Buffer::Note(bool failed) {
  if (failed && first_error_ == 0) first_error_ = errno;
}

AtomicFile::Buffer::int_type AtomicFile::Buffer::overflow(int_type c) {
  errno = 0;
  const int_type written = std::filebuf::overflow(c);
  Note(traits_type::eq_int_type(written, traits_type::eof()));
  return written;
}

std::streamsize AtomicFile::Buffer::xsputn(const char* text, std::streamsize count) {
  errno = 0;
  const std::streamsize written = std::filebuf::xsputn(text, count);
  Note(written != count);
  return written;
}

int AtomicFile::Buffer::sync() {
  errno = 0;
  const int status = std::filebuf::sync();
  Note(status != 0);
  return status;
}

bool AtomicFile::Buffer::Close() {
  errno = 0;
  const bool closed = close() != nullptr;
  Note(!closed);
  return closed;
}

AtomicFile::AtomicFile(const std::string& path)
    : path_(path), temporary_(TemporaryNameBeside(path)), stream_(&buffer_) {
  errno = 0;
  if (!buffer_.open(temporary_, std::ios::out | std::ios::binary))
    throw InputError(path_, "", Because("cannot be written"));
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  buffer_.close();
  std::remove(temporary_.c_str());
}

void AtomicFile::Commit() {
  const bool whole = buffer_.Close();  // tries again to write what is left
  if (!whole || !stream_) {
    errno = buffer_.FirstError();
    throw InputError(path_, "", Because("could not be written completely"));
  }
  CommitTemporary(temporary_, path_);
  committed_ = true;
}

}  // namespace kerf
