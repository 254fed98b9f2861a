// The channel to a server: its unary calls, and the sessions that are open on it.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/session/blob_transfer.h"
#include "client/session/call_status.h"
#include "client/session/channel_credentials.h"
#include "client/session/remote_engine.h"
#include "penumbra/v1/service.grpc.pb.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

class SceneSession;
struct SessionEntry;

class ServerConnection {
 public:
  static absl::StatusOr<std::unique_ptr<ServerConnection>> Open(RemoteEngineOptions options);
  ~ServerConnection();

  const RemoteEngineOptions& options() const { return options_; }
  v1::PenumbraService::Stub& stub() { return *stub_; }
  BlobTransfer& blobs() { return *blobs_; }
  // Of one message to the server.
  size_t max_message_bytes() const { return max_message_bytes_; }
  // What is much larger ends a session, and would end the next one. `field`, and what else there is
  // to say, are for whoever has made the request.
  //
  // Errors  kResourceExhausted QUOTA_MESSAGE
  absl::Status CheckFits(const v1::SessionRequest& request, const char* field,
                         const char* hint = "") const;

  const PresenceLimits& presence_limits() const { return presence_limits_; }

  // The session of the scene; opens one where there is none, or none that lives.
  //
  // Errors  kNotFound: no such scene; kUnavailable
  absl::StatusOr<std::shared_ptr<SceneSession>> SessionOf(const std::string& scene_id);
  // Likewise, with the user to be seen on it.
  //
  // Errors  those of SceneSession::Enter
  absl::StatusOr<std::shared_ptr<SceneSession>> EnteredSessionOf(const std::string& scene_id,
                                                                 const SessionEntry& entry);
  // The session that is open on the scene, or null. Opens none.
  std::shared_ptr<SceneSession> FindSession(const std::string& scene_id);
  // Ends a session whose scene is gone: what is under way ends with kNotFound, and the next
  // SessionOf opens another one. `session` may be null.
  void EndSessionOfDeleted(const std::string& scene_id,
                           const std::shared_ptr<SceneSession>& session);

  // Shows who calls, and sets when a call that moves so many bytes must be over.
  void Prepare(grpc::ClientContext& context, uint64_t bytes) const {
    ShowToken(options_.credentials, context);
    context.set_deadline(DeadlineFor(bytes));
  }

  // One unary call.
  template <typename Request, typename Response>
  absl::Status Call(grpc::Status (v1::PenumbraService::Stub::*method)(grpc::ClientContext*,
                                                                      const Request&, Response*),
                    const Request& request, Response* response) {
    grpc::ClientContext context;
    Prepare(context, 0);
    return StatusOfCall(options_.address, ((*stub_).*method)(&context, request, response));
  }

 private:
  ServerConnection(RemoteEngineOptions options,
                   std::shared_ptr<grpc::ChannelCredentials> credentials);
  std::chrono::system_clock::time_point DeadlineFor(uint64_t bytes) const;
  absl::Status AskForInfo(v1::GetServerInfoResponse& info);
  absl::Status Greet();
  // With mutex_ locked; null: there is none.
  std::shared_ptr<SceneSession> LivingSession(const std::string& scene_id);

  const RemoteEngineOptions options_;
  const std::shared_ptr<grpc::ChannelCredentials> credentials_;
  std::unique_ptr<v1::PenumbraService::Stub> stub_;
  std::unique_ptr<BlobTransfer> blobs_;
  size_t max_message_bytes_ = size_t{1} << 20;  // unless the server tells another one
  PresenceLimits presence_limits_;              // likewise

  std::mutex mutex_;  // of the sessions; held while one is being opened
  std::map<std::string, std::shared_ptr<SceneSession>> sessions_;
  // Sessions that have ended. Their threads are waited for at the end only: one of them may be in a
  // callback that waits for the thread that finds the session dead.
  std::vector<std::shared_ptr<SceneSession>> ended_sessions_;
};

}  // namespace penumbra
