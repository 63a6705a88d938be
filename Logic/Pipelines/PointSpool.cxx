#include "Pipelines/PointSpool.h"

#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

#include "Core/Errors.h"

namespace kerf {
namespace {

std::string Folder() {
  std::error_code error;
  const auto folder = std::filesystem::temp_directory_path(error);  // TMPDIR where it is set
  return error ? "/tmp" : folder.string();
}

[[noreturn]] void Fail(const char* what) {
  const std::string why = std::strerror(errno);
  throw InputError(
      "scratch file in " + Folder(), "",
      std::string(what) + ": " + why + ". Make room there, or set TMPDIR to another folder");
}

}  // namespace

PointSpool::PointSpool() {
  std::string path = Folder() + "/kerf-playback-XXXXXX";
  const int file = mkstemp(path.data());
  if (file < 0) Fail("cannot be made");
  unlink(path.c_str());
  file_.reset(fdopen(file, "w+b"));
  if (!file_) {
    const int why = errno;
    close(file);
    errno = why;
    Fail("cannot be made");
  }
}

PointSpool::Place PointSpool::Put(const Points& points) {
  const Place place{end_, static_cast<Index>(points.rows())};
  const auto* bytes = reinterpret_cast<const char*>(points.data());
  std::size_t left = sizeof(double) * points.size();
  while (left > 0) {
    const ssize_t written = pwrite(fileno(file_.get()), bytes, left, end_);
    if (written <= 0) Fail("cannot be written");
    bytes += written;
    end_ += written;
    left -= static_cast<std::size_t>(written);
  }
  return place;
}

Points PointSpool::Get(const Place& place) const {
  Points points(place.rows, 3);
  auto* bytes = reinterpret_cast<char*>(points.data());
  std::size_t left = sizeof(double) * points.size();
  std::int64_t at = place.offset;
  while (left > 0) {
    const ssize_t got = pread(fileno(file_.get()), bytes, left, at);
    if (got <= 0) Fail("cannot be read");
    bytes += got;
    at += got;
    left -= static_cast<std::size_t>(got);
  }
  return points;
}

}  // namespace kerf
