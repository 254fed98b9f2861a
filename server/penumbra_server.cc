#include "server/penumbra_server.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "grpcpp/health_check_service_interface.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "render/engine/local_engine.h"
#include "render/scene/field_error.h"
#include "server/gl_health.h"
#include "server/gl_worker.h"
#include "server/listen_address.h"
#include "server/metrics/job_notes.h"
#include "server/metrics/metrics_collector.h"
#include "server/metrics/metrics_endpoint.h"
#include "server/processor_admission.h"
#include "server/results/result_origin.h"
#include "server/results/stored_results.h"
#include "server/security/blob_access.h"
#include "server/security/listening_sockets.h"
#include "server/security/server_security.h"
#include "server/server_identity.h"
#include "server/service/penumbra_service.h"
#include "server/service/transfer_lanes.h"
#include "server/transport.h"

namespace penumbra {
namespace {

// Between the health service's word and the end of sessions: who directs clients to servers hears
// of it before they have to connect anew. A part of the drain.
constexpr std::chrono::milliseconds kNotice{200};
// For what gRPC has still to send when our calls have ended, and for those who watch the health
// service, who never end by themselves.
constexpr std::chrono::milliseconds kLastWords{250};

// The others outlive the engine.
LocalEngineOptions EngineOptions(const ServerOptions& options, const GlWorker& gl_worker,
                                 ServerCounters& counters, ComputeAccounts& accounts,
                                 StoredResults* stored_results) {
  return {.cpu_threads = options.threads,
          .runner_threads = options.runners,
          .max_kept_bytes = options.limits.max_kept_bytes,
          .results = {.max_bytes = options.results.memory_bytes, .store = stored_results},
          .scene_limits = options.limits.scene,
          .max_scenes = options.limits.max_scenes,
          .max_artifacts_per_scene = options.limits.max_artifacts_per_scene,
          .max_artifacts = options.limits.max_artifacts,
          .now_ms = SteadyNowMs,
          .gl_worker = [&gl_worker]() -> absl::StatusOr<gl::Worker*> {
            if (!gl_worker.ok()) return gl_worker.status();
            return gl_worker->get();
          },
          .on_job = NoteJobs(counters, *options.logger),
          .accounts = &accounts,
          .technique_for = options.technique_for};
}

absl::StatusOr<std::unique_ptr<SceneStorage>> OpenStorage(const ServerOptions& options) {
  if (options.data_dir.empty()) return nullptr;
  SceneLogOptions storage = options.storage;
  storage.history.bytes = options.limits.max_history_bytes;
  return SceneStorage::Open(options.data_dir, storage, *options.logger);
}

// Null: there are none, or they cannot be had, which costs time and nothing else.
std::unique_ptr<StoredResults> OpenResults(const ServerOptions& options,
                                           const SceneStorage* storage, const GlWorker& gl_worker) {
  if (storage == nullptr || options.results.disk_bytes == 0) return nullptr;
  auto results = StoredResults::Open({.folder = storage->results_path(),
                                      .max_bytes = options.results.disk_bytes,
                                      .origin = ResultOrigin(GlInfoOf(gl_worker)),
                                      .limits = options.limits.scene},
                                     *options.logger);
  if (results.ok()) return *std::move(results);
  options.logger->Warning("results_not_stored",
                          {{"error", std::string(results.status().message())}});
  return nullptr;
}

}  // namespace

// In the order in which they need one another; destroyed from below.
struct PenumbraServer::Parts {
  Parts(const ServerOptions& options, QuotaOptions quota_options,
        std::unique_ptr<ServerSecurity> guarding, std::unique_ptr<SceneStorage> opened)
      : limits(options.limits),
        logger(*options.logger),
        security(std::move(guarding)),
        quotas(std::move(quota_options)),
        storage(std::move(opened)),
        gl_worker(OpenGl(options, gl_health)),
        stored_results(OpenResults(options, storage.get(), gl_worker)),
        engine(EngineOptions(options, gl_worker, counters, quotas, stored_results.get())) {
    if (storage) blobs.KeepOn(storage->blob_files());
    scenes.Restore();
  }

  absl::Status ServeMetrics(const ServerOptions& options);
  absl::Status Listen(const ServerOptions& options, ListeningSockets sockets);
  MetricsGauges Gauges() const;

  const ServerLimits limits;
  Logger& logger;
  const std::unique_ptr<ServerSecurity> security;
  PrincipalQuotas quotas;
  ServerCounters counters;
  SessionLedger ledger{counters, logger};
  StreamServices stream_services{counters};
  const std::unique_ptr<SceneStorage> storage;  // null: scenes live in memory
  GlHealth gl_health;
  const GlWorker gl_worker;
  const std::unique_ptr<StoredResults> stored_results;  // null: none
  LocalEngine engine;
  BlobStore blobs{limits};
  BlobAccess blob_access{engine};
  SceneStore scenes{engine, blobs, limits, counters, storage.get()};
  SceneArchives archives{scenes};
  StreamTable streams{engine, stream_services};
  PresenceTable presence;
  SceneUpdates updates{limits.max_message_bytes};
  ProcessorAdmission processor{limits};
  SessionTable sessions{limits, quotas};
  TransferLanes transfers;
  const std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
  PenumbraService service{ServiceParts{.guard = security->guard(),
                                       .sessions = {.scenes = scenes,
                                                    .blobs = blobs,
                                                    .blob_access = blob_access,
                                                    .streams = streams,
                                                    .presence = presence,
                                                    .updates = updates,
                                                    .quotas = quotas,
                                                    .processor = processor,
                                                    .limits = limits,
                                                    .counters = counters,
                                                    .ledger = ledger},
                                       .session_table = sessions,
                                       .engine = engine,
                                       .transfers = transfers,
                                       .gl_info = [this] { return GlInfoOf(gl_worker); },
                                       .started = started,
                                       .logger = logger,
                                       .archives = archives}};
  std::string address;
  std::unique_ptr<grpc::Server> server;
  std::unique_ptr<MetricsEndpoint> metrics;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor;
  std::unique_ptr<AcceptLoop> accept_loop;
};

MetricsGauges PenumbraServer::Parts::Gauges() const {
  const std::chrono::duration<double> uptime = std::chrono::steady_clock::now() - started;
  const std::chrono::duration<double> read_delay_s = processor.read_delay().Now();
  const v1::GlInfo gl = GlInfoOf(gl_worker);
  MetricsGauges gauges{.engine = engine.statistics(),
                       .results = engine.result_statistics(),
                       .stored_result_bytes = stored_results ? stored_results->bytes() : 0,
                       .blobs = blobs.blob_count(),
                       .blob_bytes = blobs.blob_bytes(),
                       .uptime_seconds = uptime.count(),
                       .read_delay_seconds = read_delay_s.count(),
                       .is_degraded = !gl.error().empty(),
                       .gl_vendor = gl.vendor(),
                       .gl_renderer = gl.renderer(),
                       .gl_version = gl.version(),
                       .gl_device = gl.device()};
  for (const LocalEngine::SceneLoad& load : engine.scene_loads()) {
    ++gauges.scenes;
    gauges.jobs_waiting += load.jobs_waiting;
    gauges.jobs_running += load.jobs_running;
  }
  return gauges;
}

PenumbraServer::PenumbraServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

absl::StatusOr<std::unique_ptr<PenumbraServer>> PenumbraServer::Start(
    const ServerOptions& options) {
  if (auto status = CheckSecurity(options.security, options.listen); !status.ok()) return status;
  auto sockets = ListeningSockets::Open(options.listen);
  if (!sockets.ok()) return sockets.status();
  auto security = ServerSecurity::Create(options.security);
  if (!security.ok()) return security.status();
  const auto& identities = options.security.identities;
  auto quotas = ToOptions(options.quotas,
                          !identities.tokens_file.empty() || !identities.jwt_keys_file.empty());
  if (!quotas.ok()) return quotas.status();
  auto storage = OpenStorage(options);
  if (!storage.ok()) return storage.status();
  auto parts = std::make_unique<Parts>(options, *std::move(quotas), *std::move(security),
                                       *std::move(storage));
  if (auto status = CheckGpu(options, parts->gl_worker); !status.ok()) return status;
  if (auto status = parts->ServeMetrics(options); !status.ok()) return status;
  if (auto status = parts->Listen(options, *std::move(sockets)); !status.ok()) return status;
  std::unique_ptr<PenumbraServer> server(new PenumbraServer(std::move(parts)));
  server->LogStart(options);
  return server;
}

absl::Status PenumbraServer::Parts::ServeMetrics(const ServerOptions& options) {
  if (options.metrics_listen.empty()) return absl::OkStatus();
  auto opened = MetricsEndpoint::Open(
      options.metrics_listen,
      std::make_shared<MetricsCollector>(counters, [this] { return Gauges(); }));
  if (!opened.ok()) return opened.status();
  metrics = *std::move(opened);
  return absl::OkStatus();
}

absl::Status PenumbraServer::Parts::Listen(const ServerOptions& options, ListeningSockets sockets) {
  PrepareTransport();
  grpc::ServerBuilder builder;
  ConfigureTransport(options.limits, options.reflection, builder);
  using Connections = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
  acceptor = builder.experimental().AddExternalConnectionAcceptor(Connections::FROM_FD,
                                                                  security->MakeCredentials());
  builder.RegisterService(&service);
  server = builder.BuildAndStart();
  if (!server) return CannotListen(options.listen, "gRPC does not start");
  address = sockets.address();
  server->GetHealthCheckService()->SetServingStatus(v1::PenumbraService::service_full_name(), true);
  gl_health.Attach(server->GetHealthCheckService());
  accept_loop = std::make_unique<AcceptLoop>(
      std::move(sockets), security->connections(),
      [acceptor = acceptor.get()](int listener, int fd) {
        grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
        connection.listener_fd = listener;
        connection.fd = fd;
        acceptor->HandleNewConnection(&connection);
      });
  return absl::OkStatus();
}

PenumbraServer::~PenumbraServer() { Shutdown(std::chrono::milliseconds(0)); }

const std::string& PenumbraServer::address() const { return parts_->address; }

bool PenumbraServer::is_degraded() const { return !GlInfoOf(parts_->gl_worker).error().empty(); }

const std::string& PenumbraServer::metrics_address() const {
  static const std::string none;
  return parts_->metrics ? parts_->metrics->address() : none;
}

void PenumbraServer::LogStart(const ServerOptions& options) const {
  const v1::GlInfo gl = GlInfoOf(parts_->gl_worker);
  const std::string_view scenes_in =
      parts_->storage ? options.data_dir : std::string_view("memory");
  const LogField fields[] = {
      {"server", kServerName},        {"address", address()},
      {"metrics", metrics_address()}, {"threads", parts_->engine.cpu_threads()},
      {"runners", options.runners},   {"degraded", is_degraded()},
      {"gl_vendor", gl.vendor()},     {"gl_renderer", gl.renderer()},
      {"gl_version", gl.version()},   {"gl_device", gl.device()},
      {"gl_error", gl.error()},       {"scenes_in", scenes_in}};
  const LogLevel level = is_degraded() ? LogLevel::kWarning : LogLevel::kInfo;
  parts_->logger.Write(level, "started", fields);
}

// The order matters: nobody is sent here any more before those who are here have to leave.
void PenumbraServer::Shutdown(std::chrono::milliseconds drain) {
  if (!parts_->server) return;
  using std::chrono::steady_clock, std::chrono::system_clock;
  const auto deadline = steady_clock::now() + drain;
  const absl::Status reason = FieldError(absl::StatusCode::kUnavailable, "SHUTTING_DOWN", "",
                                         "the server is shutting down");
  const auto tell = [this](const char* step) {
    parts_->logger.Info("drain_step", {{"step", step},
                                       {"open_sessions", parts_->counters.open_sessions.load()},
                                       {"open_calls", parts_->counters.open_calls.load()}});
  };
  tell("health");
  parts_->server->GetHealthCheckService()->Shutdown();
  std::this_thread::sleep_for(std::min(kNotice, drain / 4));
  tell("admissions");
  parts_->sessions.Close(reason);
  tell("sessions");
  parts_->sessions.EndAll(reason);
  while (parts_->counters.open_calls > 0 && steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  tell("connections");
  parts_->accept_loop.reset();
  const auto left =
      std::chrono::duration_cast<std::chrono::milliseconds>(deadline - steady_clock::now());
  // gRPC turns what it is told by the wall clock into time of its own at once.
  parts_->server->Shutdown(system_clock::now() + std::min(left, kLastWords));
  parts_->server->Wait();
  parts_->gl_health.Detach();
  parts_->server.reset();
  parts_->transfers.Stop();
  if (parts_->storage) parts_->storage->Stop();
}

}  // namespace penumbra
