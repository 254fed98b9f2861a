#include "render/gl/context.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "render/gl/gl.h"

namespace penumbra::gl {
namespace {

// Enough for the largest scene that a software device draws in a bearable time.
constexpr size_t kDefaultMemoryBytes = size_t{1} << 30;

absl::string_view View(std::string_view text) { return {text.data(), text.size()}; }

std::string GlString(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text == nullptr ? std::string() : std::string(text);
}

int GlInt(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

absl::Status EglError(const char* call) {
  return absl::UnavailableError(
      absl::StrCat("EGL: ", call, " failed with 0x", absl::Hex(eglGetError())));
}

bool HasEglExtension(EGLDisplay display, const char* extension) {
  const char* list = eglQueryString(display, EGL_EXTENSIONS);
  return list != nullptr &&
         absl::StrContains(absl::StrCat(" ", list, " "), absl::StrCat(" ", extension, " "));
}

EGLConfig ChooseConfig(EGLDisplay display) {
  if (HasEglExtension(display, "EGL_KHR_no_config_context")) return EGL_NO_CONFIG_KHR;
  const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                           EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  eglChooseConfig(display, wanted, &config, 1, &count);
  return count > 0 ? config : nullptr;
}

EGLContext CreateNative(EGLDisplay display, EGLConfig config, bool debug, bool robust) {
  std::vector<EGLint> attributes = {
      EGL_CONTEXT_MAJOR_VERSION,       4,
      EGL_CONTEXT_MINOR_VERSION,       5,
      EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT};
  if (debug) attributes.insert(attributes.end(), {EGL_CONTEXT_OPENGL_DEBUG, EGL_TRUE});
  if (robust) {
    attributes.insert(attributes.end(),
                      {EGL_CONTEXT_OPENGL_ROBUST_ACCESS, EGL_TRUE,
                       EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
  }
  attributes.push_back(EGL_NONE);
  return eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
}

void CollectMessage(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length,
                    const GLchar* text, const void* messages) {
  constexpr size_t kMaxMessages = 64;
  if (severity == GL_DEBUG_SEVERITY_NOTIFICATION || type == GL_DEBUG_TYPE_PERFORMANCE) return;
  auto& list = *static_cast<std::vector<std::string>*>(const_cast<void*>(messages));
  if (list.size() < kMaxMessages) list.emplace_back(text, length < 0 ? 0 : length);
}

// What the device says it has, and how sure it is to be had; 0: it does not say.
size_t DeviceMemoryBytes() {
  constexpr size_t kKib = 1024;
  GLint kib[4] = {};
  if (epoxy_has_gl_extension("GL_NVX_gpu_memory_info")) {
    glGetIntegerv(GL_GPU_MEMORY_INFO_TOTAL_AVAILABLE_MEMORY_NVX, kib);
  } else if (epoxy_has_gl_extension("GL_ATI_meminfo")) {
    glGetIntegerv(GL_TEXTURE_FREE_MEMORY_ATI, kib);  // all of it, and three parts of it
  }
  return static_cast<size_t>(std::max(0, kib[0])) * kKib;
}

uint64_t NextSerial() {
  static std::atomic<uint64_t> last = 0;
  return ++last;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Context>> Context::Create(const ContextOptions& options) {
  auto display = Display::Open(options.device);
  if (!display.ok()) return display.status();
  std::unique_ptr<Context> context(new Context(options));
  context->display_ = *display;
  context->life_ = std::make_shared<ContextLife>();
  context->serial_ = NextSerial();
  if (absl::Status status = context->Initialize(); !status.ok()) return status;
  if (options.inject_fault && options.inject_fault("gl::Context") == Fault::kLost) {
    return FaultError(Fault::kLost, "gl::Context: the device is being reset");
  }
  context->life_->context = context.get();
  return context;
}

absl::Status Context::Initialize() {
  const EGLDisplay display = display_->native();
  if (!HasEglExtension(display, "EGL_KHR_surfaceless_context")) {
    return absl::UnavailableError(
        absl::StrCat("EGL: ", display_->device().name, " has no EGL_KHR_surfaceless_context"));
  }
  if (!eglBindAPI(EGL_OPENGL_API)) return EglError("eglBindAPI");
  const EGLConfig config = ChooseConfig(display);
  info_.is_robust = true;
  native_ = CreateNative(display, config, options_.debug, /*robust=*/true);
  if (native_ == EGL_NO_CONTEXT) {
    info_.is_robust = false;
    native_ = CreateNative(display, config, options_.debug, /*robust=*/false);
  }
  if (native_ == EGL_NO_CONTEXT) return EglError("eglCreateContext for OpenGL 4.5 core");
  if (absl::Status status = MakeCurrent(); !status.ok()) return status;
  if (options_.debug) CollectMessages();
  ReadInfo();
  return absl::OkStatus();
}

void Context::CollectMessages() {
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageCallback(&CollectMessage, &messages_);
}

void Context::ReadInfo() {
  info_.device = display_->device();
  info_.vendor = GlString(GL_VENDOR);
  info_.renderer = GlString(GL_RENDERER);
  info_.version = GlString(GL_VERSION);
  info_.is_software = info_.device.is_software || absl::StrContains(info_.renderer, "llvmpipe") ||
                      absl::StrContains(info_.renderer, "softpipe");
  info_.max_texture_side = GlInt(GL_MAX_TEXTURE_SIZE);
  info_.max_samples = GlInt(GL_MAX_COLOR_TEXTURE_SAMPLES);
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &info_.max_storage_bytes);
  // A software device's memory is the process's own.
  const size_t device_bytes = info_.is_software ? 0 : DeviceMemoryBytes();
  info_.max_memory_bytes = options_.max_memory_bytes > 0 ? options_.max_memory_bytes
                           : device_bytes > 0            ? device_bytes / 4 * 3
                                                         : kDefaultMemoryBytes;
  memory_ = std::make_shared<MemoryBudget>(info_.max_memory_bytes);
}

Context::~Context() {
  if (life_ != nullptr) life_->context = nullptr;
  kept_.clear();
  if (native_ == nullptr) return;
  // Messages must not reach this object while it goes.
  if (MakeCurrent().ok()) {
    glDebugMessageCallback(nullptr, nullptr);
    eglMakeCurrent(display_->native(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  eglDestroyContext(display_->native(), native_);
}

absl::Status Context::MakeCurrent() {
  if (std::this_thread::get_id() != thread_) {
    return absl::FailedPreconditionError("gl::Context: used on another thread than its own");
  }
  if (eglGetCurrentContext() == native_) return absl::OkStatus();
  if (!eglMakeCurrent(display_->native(), EGL_NO_SURFACE, EGL_NO_SURFACE, native_)) {
    return EglError("eglMakeCurrent");
  }
  return absl::OkStatus();
}

bool Context::IsLost() {
  if (loss_simulated_) return true;
  if (!MakeCurrent().ok()) return true;
  // Some drivers answer with other values; only these three mean a reset.
  const GLenum status = glGetGraphicsResetStatus();
  return status == GL_GUILTY_CONTEXT_RESET || status == GL_INNOCENT_CONTEXT_RESET ||
         status == GL_UNKNOWN_CONTEXT_RESET;
}

uint32_t Context::FirstError() {
  GLenum first = GL_NO_ERROR;
  constexpr int kMaxErrorFlags = 16;  // a lost context may report errors without end
  for (int i = 0; i < kMaxErrorFlags; ++i) {
    const GLenum error = glGetError();
    if (error == GL_NO_ERROR) break;
    if (first == GL_NO_ERROR) first = error;
  }
  return first;
}

absl::Status Context::Check(std::string_view what) {
  if (absl::Status status = MakeCurrent(); !status.ok()) return status;
  const Fault injected = options_.inject_fault ? options_.inject_fault(what) : Fault::kNone;
  if (injected == Fault::kLost) SimulateLoss();
  if (IsLost()) {
    return FaultError(Fault::kLost, absl::StrCat(View(what), ": the GL context is lost"));
  }
  GLenum error = FirstError();
  if (injected == Fault::kError) error = GL_INVALID_OPERATION;
  if (injected == Fault::kOutOfMemory) error = GL_OUT_OF_MEMORY;
  if (error == GL_NO_ERROR) return absl::OkStatus();
  if (error == GL_OUT_OF_MEMORY) {
    NoteFault(Fault::kOutOfMemory);
    return FaultError(Fault::kOutOfMemory, absl::StrCat(View(what), ": GL is out of memory"));
  }
  NoteFault(Fault::kError);
  return FaultError(Fault::kError, absl::StrCat(View(what), ": GL error 0x", absl::Hex(error), " ",
                                                absl::StrJoin(TakeMessages(), "; ")));
}

Fault Context::TakeFault() {
  const Fault fault = std::exchange(worst_fault_, Fault::kNone);
  return IsLost() ? Fault::kLost : fault;
}

absl::StatusOr<MemoryBudget::Lease> Context::TakeMemory(size_t bytes, std::string_view what) {
  if (auto lease = MemoryBudget::Take(memory_, bytes)) return *std::move(lease);
  NoteFault(Fault::kOverBudget);
  return FaultError(Fault::kOverBudget,
                    absl::StrCat(View(what), ": found ", bytes, " bytes of GPU memory beside ",
                                 memory_->used(), " in use, need at most ", memory_->limit()));
}

void Context::DropKept() {
  if (MakeCurrent().ok()) kept_.clear();
}

std::vector<std::string> Context::TakeMessages() {
  std::vector<std::string> taken;
  messages_.swap(taken);
  return taken;
}

}  // namespace penumbra::gl
