#include "Adapters/Rendering/DisplayProbe.h"

// Xlib defines macros with common names: this file includes nothing else of ours.
#include <GL/glx.h>
#include <GL/glxext.h>
#include <X11/Xlib.h>

#include <cstdio>

namespace kerf {
namespace {

int IgnoreError(Display*, XErrorEvent*) { return 0; }

bool HasContext(Display* display, std::string* why_not) {
  int error = 0, event = 0;
  if (!glXQueryExtension(display, &error, &event)) {
    *why_not = "has no GLX";
    return false;
  }
  const int wanted[] = {GLX_DRAWABLE_TYPE,
                        GLX_WINDOW_BIT,
                        GLX_RENDER_TYPE,
                        GLX_RGBA_BIT,
                        GLX_RED_SIZE,
                        1,
                        GLX_GREEN_SIZE,
                        1,
                        GLX_BLUE_SIZE,
                        1,
                        GLX_DEPTH_SIZE,
                        1,
                        GLX_DOUBLEBUFFER,
                        True,
                        None};
  int count = 0;
  GLXFBConfig* configs = glXChooseFBConfig(display, DefaultScreen(display), wanted, &count);
  if (!configs || count == 0) {
    *why_not = "has no frame buffer to draw in";
    return false;
  }
  const GLXFBConfig config = configs[0];
  XFree(configs);
  const auto create = reinterpret_cast<PFNGLXCREATECONTEXTATTRIBSARBPROC>(
      glXGetProcAddressARB(reinterpret_cast<const GLubyte*>("glXCreateContextAttribsARB")));
  const int version[] = {GLX_CONTEXT_MAJOR_VERSION_ARB, 3, GLX_CONTEXT_MINOR_VERSION_ARB, 2, None};
  const GLXContext context = create ? create(display, config, nullptr, True, version) : nullptr;
  XSync(display, False);
  if (!context) {
    *why_not = "does not offer OpenGL 3.2";
    return false;
  }
  glXDestroyContext(display, context);
  return true;
}

}  // namespace

bool ProbeDisplay(std::string* why_not) {
  Display* display = XOpenDisplay(nullptr);
  if (!display) {
    *why_not = "cannot be opened";
    return false;
  }
  const auto previous = XSetErrorHandler(IgnoreError);
  const bool ok = HasContext(display, why_not);
  XSync(display, False);
  XSetErrorHandler(previous);
  XCloseDisplay(display);
  return ok;
}

void SurviveDisplayLoss(void* x_display) {
  if (!x_display) return;
  // Xlib's own handler ends the process before it looks at the display's exit handler; ours
  // returns, so that the exit handlers decide: this display's does nothing, that of every other
  // display still ends the process.
  XSetIOErrorHandler([](Display*) {
    std::fputs("The X display was lost.\n", stderr);
    return 0;
  });
  XSetIOErrorExitHandler(
      static_cast<Display*>(x_display), [](Display*, void*) {}, nullptr);
}

}  // namespace kerf
