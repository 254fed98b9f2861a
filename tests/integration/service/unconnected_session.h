// A session with all that it works with and no connection: what it sends is taken when a test wants
// it, as by a client that reads now and then.
//
//   UnconnectedSession parts;
//   parts.Send(request);
//   while (auto response = parts.Next()) …
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "penumbra/v1/session.pb.h"
#include "server/security/server_security.h"
#include "server/session/session.h"
#include "server/session/wire_message.h"
#include "tests/integration/service/kept_log.h"
#include "tests/integration/service/studio.h"

namespace penumbra::testing {

// On the scene "studio", as the one principal of a server that asks nobody who they are.
class UnconnectedSession {
 public:
  explicit UnconnectedSession(const PrincipalQuota& quota = {})
      : quotas_({.each = quota}, [this] { return now_; }) {
    EXPECT_TRUE(scenes_.Create("studio").ok());
    scenes_.Commit("studio", {.delta = StudioDelta()}, {},
                   [](const auto& outcome) { EXPECT_TRUE(outcome.ok()) << outcome.status(); });
    const grpc::CallbackServerContext context;
    const auto caller = security_->guard().Admit(context, "Session");
    EXPECT_TRUE(caller.ok()) << caller.status();
    principal_ = caller->identity().name;
    session_ = Session::Create(
        services_, *caller, [] {}, [](const absl::Status&) {});
  }
  ~UnconnectedSession() { session_->Close(); }

  void Send(const v1::SessionRequest& request) { session_->OnRequest(ToBytes(request)); }
  // What the session would send now, if anything.
  std::optional<v1::SessionResponse> Next() {
    const auto output = session_->Next();
    if (!output.message) return std::nullopt;
    session_->OnSent();
    grpc::Slice slice;
    v1::SessionResponse response;
    EXPECT_TRUE(output.message->DumpToSingleSlice(&slice).ok());
    EXPECT_TRUE(response.ParseFromArray(slice.begin(), static_cast<int>(slice.size())));
    return response;
  }
  v1::Welcome Hello(const std::string& display_name) {
    v1::SessionRequest request;
    request.mutable_hello()->set_scene_id("studio");
    request.mutable_hello()->add_protocol_versions(1);
    request.mutable_hello()->mutable_presence()->set_display_name(display_name);
    Send(request);
    const auto response = Next();
    return response ? response->welcome() : v1::Welcome();
  }

  Session& session() { return *session_; }
  PrincipalQuotas& quotas() { return quotas_; }
  const std::string& principal() const { return principal_; }
  ProcessorAdmission& processor() { return processor_; }
  KeptLog& log() { return log_; }
  std::shared_ptr<PresenceRoom> room(const v1::Welcome& welcome) {
    return presence_.RoomOf(welcome.incarnation());
  }
  void Pass(std::chrono::seconds time) { now_ += time; }

 private:
  std::chrono::steady_clock::time_point now_{std::chrono::hours(1)};
  KeptLog log_;
  const ServerLimits limits_{};
  const std::unique_ptr<ServerSecurity> security_ = ServerSecurity::Create({}).value();
  PrincipalQuotas quotas_;
  ServerCounters counters_;
  SessionLedger ledger_{counters_, log_};
  StreamServices stream_services_{counters_};
  LocalEngine engine_{{.cpu_threads = 1}};
  BlobStore blobs_{limits_};
  BlobAccess blob_access_{engine_};
  SceneStore scenes_{engine_, blobs_, limits_, counters_, nullptr};
  StreamTable streams_{engine_, stream_services_};
  PresenceTable presence_;
  SceneUpdates updates_{limits_.max_message_bytes};
  ProcessorAdmission processor_{limits_};
  const SessionServices services_{.scenes = scenes_,
                                  .blobs = blobs_,
                                  .blob_access = blob_access_,
                                  .streams = streams_,
                                  .presence = presence_,
                                  .updates = updates_,
                                  .quotas = quotas_,
                                  .processor = processor_,
                                  .limits = limits_,
                                  .counters = counters_,
                                  .ledger = ledger_};
  std::string principal_;
  std::shared_ptr<Session> session_;
};

}  // namespace penumbra::testing
