#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>

#include "Core/Types.h"

namespace kerf {

/// Points put by into a file without a name in the folder for temporary files (TMPDIR), which goes
/// with the object: more than memory should hold. Put and Get may run in two threads at once.
class PointSpool {
 public:
  /// @throws InputError when there is no room for a scratch file
  PointSpool();
  /// Where a list of points stands.
  struct Place {
    std::int64_t offset = 0;
    Index rows = 0;
  };
  /// @throws InputError when the disk is full
  Place Put(const Points& points);
  /// Bit for bit what was put. @throws InputError
  Points Get(const Place& place) const;

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::int64_t end_ = 0;
};

}  // namespace kerf
