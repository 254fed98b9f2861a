#include "server/penumbra_server.h"

#include <utility>

#include "grpcpp/health_check_service_interface.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "render/engine/local_engine.h"
#include "render/engine/worker_pool.h"
#include "render/gl/worker.h"
#include "render/scene/field_error.h"
#include "server/listen_address.h"
#include "server/security/blob_access.h"
#include "server/security/listening_sockets.h"
#include "server/security/server_security.h"
#include "server/service/penumbra_service.h"
#include "server/transport.h"

namespace penumbra {
namespace {

// What the health service calls the GL; it is not serving where the server is degraded.
constexpr char kGlHealthName[] = "penumbra.gl";
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

GlWorker OpenGl(const ServerOptions& options) {
  if (!options.opens_gl) return absl::UnavailableError("switched off");
  return gl::Worker::Create({.context = {.device = options.egl_device}});
}

v1::GlInfo GlInfoOf(const GlWorker& worker) {
  v1::GlInfo proto;
  if (!worker.ok()) {
    proto.set_error(std::string(worker.status().message()));
    return proto;
  }
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
  Parts(const ServerOptions& options, std::unique_ptr<ServerSecurity> guarding)
      : limits(options.limits),
        security(std::move(guarding)),
        gl_worker(OpenGl(options)),
        engine(EngineOptions(options, gl_worker)) {}

  const ServerLimits limits;
  const std::unique_ptr<ServerSecurity> security;
  ServerCounters counters;
  StreamServices stream_services{counters};
  const GlWorker gl_worker;
  LocalEngine engine;
  BlobStore blobs{limits};
  BlobAccess blob_access{engine};
  SceneStore scenes{engine, limits, counters};
  StreamTable streams{engine, stream_services};
  SessionTable sessions{limits};
  WorkerPool blob_workers{{kBlobWorkers}};
  PenumbraService service{ServiceParts{.guard = security->guard(),
                                       .sessions = {.scenes = scenes,
                                                    .blobs = blobs,
                                                    .blob_access = blob_access,
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
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor;
  std::unique_ptr<AcceptLoop> accept_loop;
};

PenumbraServer::PenumbraServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

absl::StatusOr<std::unique_ptr<PenumbraServer>> PenumbraServer::Start(
    const ServerOptions& options) {
  if (auto status = CheckSecurity(options.security, options.listen); !status.ok()) return status;
  auto sockets = ListeningSockets::Open(options.listen);
  if (!sockets.ok()) return sockets.status();
  auto security = ServerSecurity::Create(options.security);
  if (!security.ok()) return security.status();
  auto parts = std::make_unique<Parts>(options, *std::move(security));
  PrepareTransport();
  grpc::ServerBuilder builder;
  ConfigureTransport(options.limits, options.reflection, builder);
  using Connections = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
  parts->acceptor = builder.experimental().AddExternalConnectionAcceptor(
      Connections::FROM_FD, parts->security->MakeCredentials());
  builder.RegisterService(&parts->service);
  parts->server = builder.BuildAndStart();
  if (!parts->server) return CannotListen(options.listen, "gRPC does not start");
  parts->address = sockets->address();
  parts->server->GetHealthCheckService()->SetServingStatus(v1::PenumbraService::service_full_name(),
                                                           true);
  parts->server->GetHealthCheckService()->SetServingStatus(kGlHealthName, parts->gl_worker.ok());
  parts->accept_loop = std::make_unique<AcceptLoop>(
      *std::move(sockets), parts->security->connections(),
      [acceptor = parts->acceptor.get()](int listener, int fd) {
        grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
        connection.listener_fd = listener;
        connection.fd = fd;
        acceptor->HandleNewConnection(&connection);
      });
  return std::unique_ptr<PenumbraServer>(new PenumbraServer(std::move(parts)));
}

PenumbraServer::~PenumbraServer() { Shutdown(std::chrono::milliseconds(0)); }

const std::string& PenumbraServer::address() const { return parts_->address; }

bool PenumbraServer::is_degraded() const { return !parts_->gl_worker.ok(); }

std::string PenumbraServer::gl_summary() const {
  const v1::GlInfo info = GlInfoOf(parts_->gl_worker);
  if (!info.error().empty()) return "none: " + info.error();
  return info.renderer() + ", OpenGL " + info.version() + ", EGL device " + info.device();
}

void PenumbraServer::Shutdown(std::chrono::milliseconds drain) {
  if (!parts_->server) return;
  parts_->sessions.EndAll(FieldError(absl::StatusCode::kUnavailable, "SHUTTING_DOWN", "",
                                     "the server is shutting down"));
  parts_->accept_loop.reset();
  parts_->server->Shutdown(std::chrono::system_clock::now() + drain);
  parts_->server->Wait();
  parts_->server.reset();
  parts_->blob_workers.Stop();
}

}  // namespace penumbra
