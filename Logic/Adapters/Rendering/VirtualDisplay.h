#pragma once

#include <string>

namespace kerf {

/// True when something can be drawn off-screen. The first call decides: the display named by
/// DISPLAY when it can draw OpenGL 3.2, otherwise a private Xvfb (1920×1080×24, no TCP, its own
/// cookie) that is started here, put into DISPLAY and ended with the process however that ends.
/// Never aborts, never throws. Call it before threads read the environment: it sets DISPLAY and
/// XAUTHORITY.
/// @param why_not a sentence for the user when false, may be null
bool RenderingAvailable(std::string* why_not = nullptr);

/// Ends the private display early, if one was started; nothing may be drawn afterwards. For tests
/// and orderly ends.
void EndVirtualDisplay();

/// Display number of the private server, or −1 when none runs.
int VirtualDisplayNumber();

}  // namespace kerf
