// The one place that includes GL and EGL. Their order matters, and X11 must stay out: nothing here
// has a window. Only sources of render/gl include this header.
#pragma once

#define EGL_NO_X11
#define MESA_EGL_NO_X11_HEADERS

// clang-format off
#include <epoxy/gl.h>
#include <epoxy/egl.h>
// clang-format on
