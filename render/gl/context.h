// An OpenGL 4.5 core context without a surface, for one thread.
//
//   auto context = gl::Context::Create({.device = "software"});
//   if (!context.ok()) return context.status();
//   auto buffer = gl::Buffer::Create(**context, 1024);
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/gl/display.h"

namespace penumbra::gl {

struct ContextOptions {
  std::string device;  // as for Display::Open
  bool debug = true;   // collect what the driver has to say
};

struct ContextInfo {
  DeviceInfo device;
  std::string vendor;
  std::string renderer;
  std::string version;  // "4.5 (Core Profile) Mesa 22.3.6"
  bool is_software = false;
  bool is_robust = false;  // out-of-range accesses are defined, and a reset is reported
  int max_texture_side = 0;
  int max_samples = 0;            // of a multisampled colour target
  int64_t max_storage_bytes = 0;  // of one shader storage block
};

class Context;

// What GL objects share with their context, so that they may outlive it.
struct ContextLife {
  Context* context = nullptr;  // null once it is gone or lost: its objects went with it
  std::atomic<int> object_count = 0;
};

// Made, used and destroyed on one thread. Several contexts may live on a thread: each function that
// takes a Context& makes it current.
class Context {
 public:
  // Errors  those of Display::Open; kUnavailable: the device has no OpenGL 4.5
  static absl::StatusOr<std::unique_ptr<Context>> Create(const ContextOptions& options = {});
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const ContextInfo& info() const { return info_; }
  // Different for every context of the process: what holds GL objects compares it to find out
  // whether they still exist.
  uint64_t serial() const { return serial_; }
  int object_count() const { return life_->object_count; }
  const std::shared_ptr<ContextLife>& life() const { return life_; }

  // Errors  kFailedPrecondition: called on another thread than the one that created the context
  absl::Status MakeCurrent();

  // Whether GL is well after `what`. Poll once for each job.
  //
  // Errors  kUnavailable: the context is lost; kResourceExhausted: GL ran out of memory;
  //         kInternal: any other GL error, with the driver's messages
  absl::Status Check(std::string_view what);

  bool IsLost();
  // Makes the context report a loss from now on, for software drivers never do.
  void SimulateLoss() { loss_simulated_ = true; }

  // What one user of the context keeps in it from one job to the next: null at first, and gone with
  // the context, on its thread. `owner` is any address that is the user's own.
  std::shared_ptr<void>& Kept(const void* owner) { return kept_[owner]; }

  // The driver's warnings and errors since the last call, oldest first, at most 64 of them.
  std::vector<std::string> TakeMessages();

 private:
  Context() = default;
  absl::Status Initialize(const ContextOptions& options);
  void CollectMessages();
  void ReadInfo();

  const Display* display_ = nullptr;
  void* native_ = nullptr;  // EGLContext
  std::thread::id thread_ = std::this_thread::get_id();
  ContextInfo info_;
  uint64_t serial_ = 0;
  bool loss_simulated_ = false;
  std::vector<std::string> messages_;
  std::shared_ptr<ContextLife> life_;
  std::map<const void*, std::shared_ptr<void>> kept_;
};

// The name of a GL object and the duty to delete it. Move-only. Deletes on the context's thread
// while the context lives; afterwards there is nothing to delete.
class ObjectName {
 public:
  using Delete = void (*)(uint32_t name);

  ObjectName() = default;
  ObjectName(Context& context, uint32_t name, Delete deleter);
  ObjectName(ObjectName&& other) noexcept;
  ObjectName& operator=(ObjectName&& other) noexcept;
  ~ObjectName();

  uint32_t get() const { return name_; }

 private:
  std::shared_ptr<ContextLife> life_;
  uint32_t name_ = 0;
  Delete delete_ = nullptr;
};

}  // namespace penumbra::gl
