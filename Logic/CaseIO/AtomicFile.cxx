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

void Sync(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
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
  Sync(temporary);
  if (std::rename(temporary.c_str(), path.c_str()) != 0) {
    const std::string problem = std::strerror(errno);
    std::remove(temporary.c_str());
    throw InputError(path, "", "cannot be written: " + problem);
  }
}

void WriteThrough(std::ofstream* stream, const std::string& path, const std::string& text) {
  errno = 0;
  *stream << text << std::flush;
  if (!*stream) throw InputError(path, "", Because("cannot be written any more"));
}

AtomicFile::AtomicFile(const std::string& path)
    : path_(path), temporary_(TemporaryNameBeside(path)), stream_(temporary_, std::ios::binary) {
  if (!stream_) throw InputError(path_, "", std::string("cannot be written: ") + strerror(errno));
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  stream_.close();
  std::remove(temporary_.c_str());
}

void AtomicFile::Commit() {
  errno = 0;
  stream_.close();  // tries again to write what is left: the reason is that of the first failure
  if (!stream_) throw InputError(path_, "", Because("could not be written completely"));
  CommitTemporary(temporary_, path_);
  committed_ = true;
}

}  // namespace kerf
