#pragma once

#include <string>

namespace kerf {

/// Can the display named by DISPLAY give an OpenGL 3.2 context? VTK aborts the process where it
/// can't, so this is asked first. @param why_not what is missing, when false
bool ProbeDisplay(std::string* why_not);

/// From now on the loss of this X connection does not end the process, as Xlib would: off-screen
/// drawing in software needs no server any more, and a recorded operation is not to be lost for
/// one. @param x_display Xlib's Display*
void SurviveDisplayLoss(void* x_display);

}  // namespace kerf
