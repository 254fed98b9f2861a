#include "client/session/server_connection.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "client/session/scene_session.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/support/channel_arguments.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// An upload on a slow line gets one call timeout more for each of these.
constexpr double kBytesPerCallTimeout = 16.0 * 1024 * 1024;

std::shared_ptr<grpc::Channel> MakeChannel(
    const RemoteEngineOptions& options,
    const std::shared_ptr<grpc::ChannelCredentials>& credentials) {
  grpc::ChannelArguments arguments;
  // A connection of its own: one engine's trouble is not another's.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  // A session that tries to resume decides itself how long to wait.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 1'000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2'000);
  // The address says where the server is; a proxy for web pages has no part in it.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  const int keepalive_ms = static_cast<int>(1e3 * options.keepalive_s);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, keepalive_ms);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, keepalive_ms);
  // A session may have nothing to send for hours.
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  return grpc::CreateCustomChannel(options.address, credentials, arguments);
}

std::chrono::system_clock::time_point After(double seconds) {
  return std::chrono::system_clock::now() +
         std::chrono::duration_cast<std::chrono::system_clock::duration>(
             std::chrono::duration<double>(seconds));
}

}  // namespace

ServerConnection::ServerConnection(RemoteEngineOptions options,
                                   std::shared_ptr<grpc::ChannelCredentials> credentials)
    : options_(std::move(options)),
      credentials_(std::move(credentials)),
      stub_(v1::PenumbraService::NewStub(MakeChannel(options_, credentials_))) {}

ServerConnection::~ServerConnection() {
  for (auto& [id, session] : sessions_) ended_sessions_.push_back(std::move(session));
  for (const auto& session : ended_sessions_) session->End(absl::CancelledError("engine closed"));
  for (const auto& session : ended_sessions_) session->Join();
}

absl::StatusOr<std::unique_ptr<ServerConnection>> ServerConnection::Open(
    RemoteEngineOptions options) {
  auto credentials = MakeChannelCredentials(options.address, options.credentials);
  if (!credentials.ok()) return credentials.status();
  std::unique_ptr<ServerConnection> connection(
      new ServerConnection(std::move(options), *std::move(credentials)));
  if (absl::Status status = connection->Greet(); !status.ok()) return status;
  return connection;
}

absl::Status ServerConnection::AskForInfo(v1::GetServerInfoResponse& info) {
  grpc::ClientContext context;
  ShowToken(options_.credentials, context);
  context.set_deadline(After(options_.connect_timeout_s));
  return StatusOfCall(options_.address,
                      stub_->GetServerInfo(&context, v1::GetServerInfoRequest(), &info));
}

// Finds out at once whether there is a server, and what it accepts.
absl::Status ServerConnection::Greet() {
  v1::GetServerInfoResponse info;
  absl::Status status = AskForInfo(info);
  if (absl::IsUnavailable(status)) {
    // gRPC before 1.61 looks at errno some calls after connect() (its pull request 35064). One of
    // them may have made a connection that is coming about look like one that failed: malloc does
    // where there is no /sys. On a channel of its own a second try need not wait.
    stub_ = v1::PenumbraService::NewStub(MakeChannel(options_, credentials_));
    status = AskForInfo(info);
  }
  if (!status.ok()) return status;
  if (info.limits().max_message_bytes() > 0) max_message_bytes_ = info.limits().max_message_bytes();
  if (info.limits().max_display_name_bytes() > 0) {
    presence_limits_ = {.max_display_name_bytes = info.limits().max_display_name_bytes(),
                        .max_selected_ids = info.limits().max_selected_ids()};
  }
  blobs_ = std::make_unique<BlobTransfer>(*this, info.limits());
  return absl::OkStatus();
}

absl::Status ServerConnection::CheckFits(const v1::SessionRequest& request, const char* field,
                                         const char* hint) const {
  const size_t bytes = request.ByteSizeLong();
  if (bytes <= max_message_bytes_) return absl::OkStatus();
  return FieldError(
      absl::StatusCode::kResourceExhausted, "QUOTA_MESSAGE", field,
      absl::StrCat("found ", bytes, " bytes, need at most ", max_message_bytes_, hint));
}

std::chrono::system_clock::time_point ServerConnection::DeadlineFor(uint64_t bytes) const {
  return After(options_.call_timeout_s * (1.0 + static_cast<double>(bytes) / kBytesPerCallTimeout));
}

std::shared_ptr<SceneSession> ServerConnection::LivingSession(const std::string& scene_id) {
  const auto found = sessions_.find(scene_id);
  if (found == sessions_.end()) return nullptr;
  if (!found->second->has_ended()) return found->second;
  ended_sessions_.push_back(std::move(found->second));
  sessions_.erase(found);
  return nullptr;
}

absl::StatusOr<std::shared_ptr<SceneSession>> ServerConnection::SessionOf(
    const std::string& scene_id) {
  std::lock_guard lock(mutex_);
  if (auto living = LivingSession(scene_id)) return living;
  auto session = SceneSession::Open(*this, scene_id);
  if (session.ok()) sessions_[scene_id] = *session;
  return session;
}

absl::StatusOr<std::shared_ptr<SceneSession>> ServerConnection::EnteredSessionOf(
    const std::string& scene_id, const SessionEntry& entry) {
  std::lock_guard lock(mutex_);
  if (auto living = LivingSession(scene_id)) {
    if (auto status = living->Enter(entry); !status.ok()) return status;
    return living;
  }
  auto session = SceneSession::Open(*this, scene_id, entry);
  if (session.ok()) sessions_[scene_id] = *session;
  return session;
}

std::shared_ptr<SceneSession> ServerConnection::FindSession(const std::string& scene_id) {
  std::lock_guard lock(mutex_);
  const auto found = sessions_.find(scene_id);
  return found == sessions_.end() ? nullptr : found->second;
}

void ServerConnection::EndSessionOfDeleted(const std::string& scene_id,
                                           const std::shared_ptr<SceneSession>& session) {
  if (session == nullptr) return;
  session->End(FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                          "found '" + scene_id + "', which was deleted, need a scene"));
  std::lock_guard lock(mutex_);
  const auto found = sessions_.find(scene_id);
  if (found == sessions_.end() || found->second != session) return;
  ended_sessions_.push_back(std::move(found->second));
  sessions_.erase(found);
}

}  // namespace penumbra
