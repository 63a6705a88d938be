#pragma once

#include <string>

namespace kerf {

/// Can the display named by DISPLAY give an OpenGL 3.2 context? VTK aborts the process where it
/// can't, so this is asked first. @param why_not what is missing, when false
bool ProbeDisplay(std::string* why_not);

}  // namespace kerf
