// The EGL device that tests draw on: the software one, which every test machine has, or the one
// that PENUMBRA_TEST_EGL_DEVICE names.
//
//   auto context = gl::Context::Create({.device = TestDevice()});
#pragma once

#include <cstdlib>
#include <string>

namespace penumbra {

inline std::string TestDevice() {
  const char* const named = std::getenv("PENUMBRA_TEST_EGL_DEVICE");
  return named ? named : "software";
}

}  // namespace penumbra
