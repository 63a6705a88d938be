#pragma once

#include <QtGlobal>
#include <cstdio>
#include <string>

#include "Adapters/Rendering/VirtualDisplay.h"

namespace kerf::testing {

/// What a GUI test's main() returns where there is no display, and ctest takes for skipped.
constexpr int kNoDisplay = 77;

/// Makes Qt draw on the display, or on a private one where there is none; before the application is
/// made. @return false, with a word on stderr, where neither is to be had
inline bool DisplayForQt() {
  std::string why_not;
  if (!RenderingAvailable(&why_not)) {
    std::fprintf(stderr, "no display: %s\n", why_not.c_str());
    return false;
  }
  qputenv("QT_QPA_PLATFORM", "xcb");
  return true;
}

}  // namespace kerf::testing
