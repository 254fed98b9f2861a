// The EGL devices of this machine, without a window system.
//
//   auto display = gl::Display::Open();            // first hardware device, else the software one
//   auto display = gl::Display::Open("software");  // by index or by part of a name
//   if (!display.ok()) return display.status();
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace penumbra::gl {

struct DeviceInfo {
  int index = -1;  // place in EGL's enumeration; −1: the surfaceless platform, which has no device
  std::string name;  // "software", "/dev/dri/card0", "cuda0", "surfaceless"
  bool is_software = false;
};

// An initialised EGL display. Opened once for each device and kept until the process ends: to end
// one would invalidate every context made from it, whoever owns that. Any thread may ask.
class Display {
 public:
  // The devices that EGL enumerates. They need not all work.
  //
  // Errors  kUnavailable: there is no EGL, or it cannot enumerate devices
  static absl::StatusOr<std::vector<DeviceInfo>> Devices();

  // The display of the device that `selector` names: an index, or part of a name with upper and
  // lower case alike. Empty: the first hardware device that works, else the software one, else
  // Mesa's surfaceless platform.
  //
  // Errors  kUnavailable: nothing usable; the message tells what was tried
  //         kNotFound: no device of that name; the message lists those there are
  static absl::StatusOr<const Display*> Open(std::string_view selector = {});

  const DeviceInfo& device() const { return device_; }
  // The EGLDisplay, never null.
  void* native() const { return native_; }

 private:
  friend class DisplayTable;
  Display(DeviceInfo device, void* native) : device_(std::move(device)), native_(native) {}

  DeviceInfo device_;
  void* native_;
};

}  // namespace penumbra::gl
