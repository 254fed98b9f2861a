// An OpenGL 4.5 core context without a surface, for one thread.
//
//   auto context = gl::Context::Create({.device = "software"});
//   if (!context.ok()) return context.status();
//   auto buffer = gl::Buffer::Create(**context, 1024);
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/gl/display.h"
#include "render/gl/fault.h"
#include "render/gl/memory_budget.h"
#include "render/gl/object_name.h"

namespace penumbra::gl {

struct ContextOptions {
  std::string device;  // as for Display::Open
  bool debug = true;   // collect what the driver has to say
  // That textures and buffers may take in all; 0: three quarters of what the device says it has,
  // or 1 GiB where it does not say, as software devices do not.
  size_t max_memory_bytes = 0;
  std::function<double()> now_ms = nullptr;  // a clock that only goes forward; null: there is none
  FaultInjector inject_fault = nullptr;      // of tests
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
  size_t max_memory_bytes = 0;    // of all textures and buffers together
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
  // Errors  those of FaultError. kUnavailable: the context is lost; kResourceExhausted: GL ran out
  //         of memory; kInternal: any other GL error, with the driver's messages
  absl::Status Check(std::string_view what);

  // To be kept for as long as `bytes` of GPU memory are, and asked for before GL is.
  //
  // Errors  kResourceExhausted: Fault::kOverBudget
  absl::StatusOr<MemoryBudget::Lease> TakeMemory(size_t bytes, std::string_view what);
  const MemoryBudget& memory() const { return *memory_; }

  // The worst that has befallen it since the last call; once lost it stays so.
  Fault TakeFault();
  void NoteFault(Fault fault) { worst_fault_ = std::max(worst_fault_, fault); }

  // By the clock of the options; 0 without one.
  double NowMs() const { return options_.now_ms ? options_.now_ms() : 0.0; }
  bool has_clock() const { return options_.now_ms != nullptr; }

  bool IsLost();
  // Makes the context report a loss from now on, for software drivers never do.
  void SimulateLoss() { loss_simulated_ = true; }

  // What one user of the context keeps in it from one job to the next: null at first, and gone with
  // the context, on its thread. `owner` is any address that is the user's own.
  std::shared_ptr<void>& Kept(const void* owner) { return kept_[owner]; }
  // Lets go of all that, to free memory. Between jobs: who uses it does not expect it to go.
  void DropKept();

  // The driver's warnings and errors since the last call, oldest first, at most 64 of them.
  std::vector<std::string> TakeMessages();

 private:
  explicit Context(const ContextOptions& options) : options_(options) {}
  absl::Status Initialize();
  void CollectMessages();
  void ReadInfo();
  uint32_t FirstError();

  const ContextOptions options_;
  const Display* display_ = nullptr;
  void* native_ = nullptr;  // EGLContext
  std::thread::id thread_ = std::this_thread::get_id();
  ContextInfo info_;
  uint64_t serial_ = 0;
  bool loss_simulated_ = false;
  Fault worst_fault_ = Fault::kNone;
  std::shared_ptr<MemoryBudget> memory_;
  std::vector<std::string> messages_;
  std::shared_ptr<ContextLife> life_;
  std::map<const void*, std::shared_ptr<void>> kept_;
};

}  // namespace penumbra::gl
