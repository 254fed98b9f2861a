// The whole server in one object: what penumbrad runs, and what tests and benchmarks embed.
//
//   auto server = PenumbraServer::Start({.listen = "127.0.0.1:0"});
//   if (!server.ok()) return server.status();
//   Connect((*server)->address());
//   (*server)->Shutdown(std::chrono::seconds(5));
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/gl/fault.h"
#include "render/technique/technique.h"
#include "server/limits.h"
#include "server/log/logger.h"
#include "server/quota/quota_options.h"
#include "server/scene_store/scene_log.h"
#include "server/security/security_options.h"

namespace penumbra {

// Of final artifacts that were computed, to be found again (render/engine/result_cache.h).
struct ResultOptions {
  size_t memory_bytes = 0;  // 0: none
  uint64_t disk_bytes = 0;  // where there is a data_dir; 0: none
};

struct ServerOptions {
  std::string listen = "127.0.0.1:7717";  // see listen_address.h
  int threads = 0;                        // that compute; 0: as many as the hardware has
  int runners = 2;                        // artifacts that are computed at a time, besides points
  std::string egl_device;                 // see gl::Display::Open
  bool opens_gl = true;                   // otherwise the server is degraded
  bool require_gpu = false;               // start on a hardware device or not at all
  size_t gpu_memory_bytes = 0;            // see gl::ContextOptions::max_memory_bytes
  gl::FaultInjector inject_gl_fault = nullptr;  // of tests
  bool reflection = false;
  std::string metrics_listen;  // see MetricsEndpoint; empty: no metrics are served
  std::string data_dir;        // where scenes are kept; empty: in memory only, gone with the server
  SceneLogOptions storage{};
  ResultOptions results{};
  SecurityOptions security{};
  ServerLimits limits{};
  QuotaSettings quotas{};
  Logger* logger = &QuietLogger();  // outlives the server
  // What computes a spec; tests put their own here. It must outlive the server.
  std::function<const Technique&(const TechniqueParams&)> technique_for = TechniqueFor;
};

class PenumbraServer {
 public:
  // Listens when it returns. Without an EGL device it starts, and says that it is degraded.
  //
  // Errors  those of CheckSecurity, ServerSecurity::Create, ToOptions of quotas, listen_address.h,
  //         DataDirectory and MetricsEndpoint::Open; kFailedPrecondition NO_GPU: require_gpu
  static absl::StatusOr<std::unique_ptr<PenumbraServer>> Start(const ServerOptions& options);
  ~PenumbraServer();  // Shutdown without a wait

  // Where clients connect to, with the port that was taken.
  const std::string& address() const;
  bool is_degraded() const;

  // Where the metrics are served, with the port that was taken; empty where they are not.
  const std::string& metrics_address() const;

  // Tells the health service's clients, lets no more sessions in, ends those that are open with
  // kUnavailable SHUTTING_DOWN once their replies are sent, waits for other calls to end, and
  // cancels what has not ended after `drain`. Only the first call does anything.
  void Shutdown(std::chrono::milliseconds drain);

 private:
  struct Parts;
  explicit PenumbraServer(std::unique_ptr<Parts> parts);
  void LogStart(const ServerOptions& options) const;

  std::unique_ptr<Parts> parts_;
};

}  // namespace penumbra
