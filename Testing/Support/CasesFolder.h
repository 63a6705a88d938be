#pragma once

#include <cstdlib>
#include <filesystem>

namespace kerf::testing {

/// Where the studies with truth are: KERF_CASES, or beside the checkout. They are not part of it:
/// who needs one skips where it is absent.
inline std::filesystem::path CasesFolder() {
  const char* given = std::getenv("KERF_CASES");
  return given ? given : KERF_CASES_DEFAULT;
}

}  // namespace kerf::testing
