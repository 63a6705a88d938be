#include "Pipelines/PointSpool.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "Core/Errors.h"

namespace kerf {
namespace {

[[noreturn]] void Fail(const char* what) {
  throw InputError("scratch file", "", std::string(what) + ": " + std::strerror(errno));
}

}  // namespace

PointSpool::PointSpool() : file_(std::tmpfile()) {
  if (!file_) Fail("cannot be made");
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
