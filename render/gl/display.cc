#include "render/gl/display.h"

#include <dlfcn.h>

#include <map>
#include <memory>
#include <mutex>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "render/gl/gl.h"

namespace penumbra::gl {
namespace {

absl::string_view View(std::string_view text) { return {text.data(), text.size()}; }

// libepoxy ends the process when the library behind it is missing, so we look first. The handles
// stay open: they are the ones that libepoxy will use.
absl::Status CheckLibraries() {
  static const bool has_egl = dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL) != nullptr;
  static const bool has_gl = dlopen("libOpenGL.so.0", RTLD_LAZY | RTLD_LOCAL) != nullptr ||
                             dlopen("libGL.so.1", RTLD_LAZY | RTLD_LOCAL) != nullptr;
  if (!has_egl) return absl::UnavailableError("EGL: libEGL.so.1 is not installed");
  if (!has_gl)
    return absl::UnavailableError("EGL: neither libOpenGL.so.0 nor libGL.so.1 is installed");
  return absl::OkStatus();
}

bool HasWord(const char* list, absl::string_view word) {
  return list != nullptr &&
         absl::StrContains(absl::StrCat(" ", list, " "), absl::StrCat(" ", word, " "));
}

// The EGL extension functions, asked for by name: libepoxy's own look-up needs a display that
// exists.
template <typename Function>
Function Load(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

bool ClientHas(absl::string_view extension) {
  return HasWord(eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), extension);
}

DeviceInfo Describe(int index, EGLDeviceEXT device) {
  DeviceInfo info{.index = index, .name = absl::StrCat("device", index)};
  const auto query = Load<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  const auto query_attribute = Load<PFNEGLQUERYDEVICEATTRIBEXTPROC>("eglQueryDeviceAttribEXT");
  if (query == nullptr) return info;
  const char* extensions = query(device, EGL_EXTENSIONS);
  EGLAttrib cuda = 0;
  const char* drm =
      HasWord(extensions, "EGL_EXT_device_drm") ? query(device, EGL_DRM_DEVICE_FILE_EXT) : nullptr;
  if (HasWord(extensions, "EGL_MESA_device_software")) {
    info.name = "software";
    info.is_software = true;
  } else if (drm != nullptr) {
    info.name = drm;
  } else if (HasWord(extensions, "EGL_NV_device_cuda") && query_attribute != nullptr &&
             query_attribute(device, EGL_CUDA_DEVICE_NV, &cuda)) {
    info.name = absl::StrCat("cuda", cuda);
  }
  return info;
}

absl::StatusOr<std::vector<EGLDeviceEXT>> NativeDevices() {
  if (absl::Status status = CheckLibraries(); !status.ok()) return status;
  const auto query = Load<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  const bool can_enumerate =
      ClientHas("EGL_EXT_device_enumeration") || ClientHas("EGL_EXT_device_base");
  EGLint count = 0;
  if (!can_enumerate || query == nullptr || !query(0, nullptr, &count)) {
    return absl::UnavailableError("EGL: devices cannot be enumerated (EGL_EXT_device_enumeration)");
  }
  std::vector<EGLDeviceEXT> devices(count);
  if (count > 0 && !query(count, devices.data(), &count)) {
    return absl::UnavailableError("EGL: enumerating devices failed");
  }
  devices.resize(count);
  return devices;
}

absl::StatusOr<EGLDisplay> Initialize(EGLenum platform, void* device, absl::string_view extension) {
  const auto get_display = Load<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  if (get_display == nullptr || !ClientHas(extension)) {
    return absl::UnavailableError(absl::StrCat("no ", extension));
  }
  const EGLDisplay display = get_display(platform, device, nullptr);
  if (display == EGL_NO_DISPLAY) return absl::UnavailableError("no display");
  EGLint major = 0, minor = 0;
  if (!eglInitialize(display, &major, &minor)) {
    return absl::UnavailableError(
        absl::StrCat("eglInitialize failed with 0x", absl::Hex(eglGetError())));
  }
  return display;
}

bool Matches(const DeviceInfo& device, absl::string_view selector) {
  int index = 0;
  if (absl::SimpleAtoi(selector, &index)) return device.index == index;
  return absl::StrContains(absl::AsciiStrToLower(device.name), absl::AsciiStrToLower(selector));
}

}  // namespace

// The displays opened so far, by device index; −1 is the surfaceless platform.
class DisplayTable {
 public:
  static DisplayTable& Get() {
    static auto* table = new DisplayTable;  // never destroyed: see Display
    return *table;
  }

  absl::StatusOr<const Display*> Open(const DeviceInfo& device, EGLDeviceEXT native) {
    const std::lock_guard lock(mutex_);
    if (const auto it = displays_.find(device.index); it != displays_.end())
      return it->second.get();
    auto display = device.index < 0
                       ? Initialize(EGL_PLATFORM_SURFACELESS_MESA,
                                    reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY),
                                    "EGL_MESA_platform_surfaceless")
                       : Initialize(EGL_PLATFORM_DEVICE_EXT, native, "EGL_EXT_platform_device");
    if (!display.ok()) {
      return absl::UnavailableError(absl::StrCat(device.name, ": ", display.status().message()));
    }
    auto& kept = displays_[device.index];
    kept.reset(new Display(device, *display));
    return kept.get();
  }

 private:
  std::mutex mutex_;
  std::map<int, std::unique_ptr<Display>> displays_;
};

absl::StatusOr<std::vector<DeviceInfo>> Display::Devices() {
  const auto natives = NativeDevices();
  if (!natives.ok()) return natives.status();
  std::vector<DeviceInfo> devices;
  for (size_t i = 0; i < natives->size(); ++i) {
    devices.push_back(Describe(static_cast<int>(i), (*natives)[i]));
  }
  return devices;
}

absl::StatusOr<const Display*> Display::Open(std::string_view selector) {
  if (absl::Status status = CheckLibraries(); !status.ok()) return status;
  const auto enumerated = NativeDevices();
  const std::vector<EGLDeviceEXT> natives =
      enumerated.ok() ? *enumerated : std::vector<EGLDeviceEXT>();
  std::vector<DeviceInfo> ladder, software;
  for (size_t i = 0; i < natives.size(); ++i) {
    const DeviceInfo device = Describe(static_cast<int>(i), natives[i]);
    (device.is_software ? software : ladder).push_back(device);
  }
  ladder.insert(ladder.end(), software.begin(), software.end());
  ladder.push_back({.index = -1, .name = "surfaceless", .is_software = true});

  std::vector<std::string> tried, names;
  for (const DeviceInfo& device : ladder) {
    names.push_back(device.index < 0 ? device.name : absl::StrCat(device.index, " ", device.name));
    if (!selector.empty() && !Matches(device, View(selector))) continue;
    auto display =
        DisplayTable::Get().Open(device, device.index < 0 ? nullptr : natives[device.index]);
    if (display.ok()) return display;
    tried.emplace_back(display.status().message());
  }
  if (tried.empty()) {
    return absl::NotFoundError(absl::StrCat("EGL device: found no \"", View(selector),
                                            "\", need one of: ", absl::StrJoin(names, ", ")));
  }
  if (!enumerated.ok()) tried.emplace_back(enumerated.status().message());
  return absl::UnavailableError(
      absl::StrCat("EGL: no usable device (", absl::StrJoin(tried, "; "), ")"));
}

}  // namespace penumbra::gl
