#include "server/penumbra_server.h"

#include <utility>

#include "grpcpp/health_check_service_interface.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "render/engine/local_engine.h"
#include "render/engine/worker_pool.h"
#include "render/gl/worker.h"
#include "render/scene/field_error.h"
#include "server/gl_health.h"
#include "server/listen_address.h"
#include "server/service/penumbra_service.h"
#include "server/transport.h"

namespace penumbra {
namespace {

constexpr int kBlobWorkers = 1;  // a blob takes one core; uploads that come together take turns

double SteadyNowMs() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

using GlWorker = absl::StatusOr<std::unique_ptr<gl::Worker>>;

// `gl_worker` outlives the engine.
LocalEngineOptions EngineOptions(const ServerOptions& options, const GlWorker& gl_worker) {
  return {.cpu_threads = options.threads,
          .runner_threads = options.runners,
          .max_kept_bytes = options.limits.max_kept_bytes,
          .scene_limits = options.limits.scene,
          .max_scenes = options.limits.max_scenes,
          .max_artifacts_per_scene = options.limits.max_artifacts_per_scene,
          .now_ms = SteadyNowMs,
          .gl_worker = [&gl_worker]() -> absl::StatusOr<gl::Worker*> {
            if (!gl_worker.ok()) return gl_worker.status();
            return gl_worker->get();
          },
          .technique_for = options.technique_for};
}

GlWorker OpenGl(const ServerOptions& options, GlHealth& health) {
  if (!options.opens_gl) return absl::UnavailableError("switched off");
  auto worker = gl::Worker::Create(
      {.context = {.device = options.egl_device,
                   .max_memory_bytes = options.gpu_memory_bytes,
                   .now_ms = SteadyNowMs,
                   .inject_fault = options.inject_gl_fault},
       .on_health_change = [&health](bool is_degraded) { health.Set(!is_degraded); }});
  health.Set(worker.ok());
  return worker;
}

absl::Status CheckGpu(const ServerOptions& options, const GlWorker& worker) {
  if (!options.require_gpu) return absl::OkStatus();
  if (worker.ok() && !(*worker)->info().is_software) return absl::OkStatus();
  return FieldError(absl::StatusCode::kFailedPrecondition, "NO_GPU", "require-gpu",
                    "found " +
                        (worker.ok() ? (*worker)->info().renderer + ", which is software"
                                     : std::string(worker.status().message())) +
                        ", need a hardware device");
}

v1::GlInfo GlInfoOf(const GlWorker& worker) {
  v1::GlInfo proto;
  if (!worker.ok()) {
    proto.set_error(std::string(worker.status().message()));
    return proto;
  }
  proto.set_error((*worker)->health().reason());
  const gl::ContextInfo info = (*worker)->info();
  proto.set_device(info.device.name);
  proto.set_vendor(info.vendor);
  proto.set_renderer(info.renderer);
  proto.set_version(info.version);
  return proto;
}

}  // namespace

// In the order in which they need one another; destroyed from below.
struct PenumbraServer::Parts {
  explicit Parts(const ServerOptions& options)
      : limits(options.limits),
        gl_worker(OpenGl(options, gl_health)),
        engine(EngineOptions(options, gl_worker)) {}

  const ServerLimits limits;
  ServerCounters counters;
  StreamServices stream_services{counters};
  GlHealth gl_health;
  const GlWorker gl_worker;
  LocalEngine engine;
  BlobStore blobs{limits};
  SceneStore scenes{engine, limits, counters};
  StreamTable streams{engine, stream_services};
  SessionTable sessions{limits};
  WorkerPool blob_workers{{kBlobWorkers}};
  PenumbraService service{ServiceParts{.sessions = {.scenes = scenes,
                                                    .blobs = blobs,
                                                    .streams = streams,
                                                    .limits = limits,
                                                    .counters = counters},
                                       .session_table = sessions,
                                       .engine = engine,
                                       .blob_workers = blob_workers.lane(0),
                                       .gl_info = [this] { return GlInfoOf(gl_worker); },
                                       .started = std::chrono::steady_clock::now()}};
  std::string address;
  std::unique_ptr<grpc::Server> server;
};

PenumbraServer::PenumbraServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

absl::StatusOr<std::unique_ptr<PenumbraServer>> PenumbraServer::Start(
    const ServerOptions& options) {
  if (auto status = CheckListenAddress(options.listen); !status.ok()) return status;
  if (auto status = TryListening(options.listen); !status.ok()) return status;
  auto parts = std::make_unique<Parts>(options);
  if (auto status = CheckGpu(options, parts->gl_worker); !status.ok()) return status;
  PrepareTransport();
  grpc::ServerBuilder builder;
  ConfigureTransport(options.limits, options.reflection, builder);
  int port = 0;
  builder.AddListeningPort(options.listen, grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&parts->service);
  parts->server = builder.BuildAndStart();
  if (!parts->server) {
    return FieldError(absl::StatusCode::kUnavailable, "CANNOT_LISTEN", "listen",
                      "found " + options.listen + ", need an address to listen on");
  }
  parts->address = options.listen;
  if (!options.listen.starts_with("unix:")) {
    parts->address = options.listen.substr(0, options.listen.rfind(':') + 1) + std::to_string(port);
  }
  parts->server->GetHealthCheckService()->SetServingStatus(v1::PenumbraService::service_full_name(),
                                                           true);
  parts->gl_health.Attach(parts->server->GetHealthCheckService());
  return std::unique_ptr<PenumbraServer>(new PenumbraServer(std::move(parts)));
}

PenumbraServer::~PenumbraServer() { Shutdown(std::chrono::milliseconds(0)); }

const std::string& PenumbraServer::address() const { return parts_->address; }

bool PenumbraServer::is_degraded() const { return !GlInfoOf(parts_->gl_worker).error().empty(); }

std::string PenumbraServer::gl_summary() const {
  const v1::GlInfo info = GlInfoOf(parts_->gl_worker);
  if (info.renderer().empty()) return "none: " + info.error();
  return info.renderer() + ", OpenGL " + info.version() + ", EGL device " + info.device();
}

void PenumbraServer::Shutdown(std::chrono::milliseconds drain) {
  if (!parts_->server) return;
  parts_->sessions.EndAll(FieldError(absl::StatusCode::kUnavailable, "SHUTTING_DOWN", "",
                                     "the server is shutting down"));
  parts_->server->Shutdown(std::chrono::system_clock::now() + drain);
  parts_->server->Wait();
  parts_->gl_health.Detach();
  parts_->server.reset();
  parts_->blob_workers.Stop();
}

}  // namespace penumbra
