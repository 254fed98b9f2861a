// The one way into the service: every call asks here who calls and whether they may.
//
//   auto caller = guard.Admit(*context, "CreateScene");
//   if (!caller.ok()) return Finish(ToGrpcStatus(caller.status()));
//   if (auto status = caller->Authorize("CreateScene", scene_id); !status.ok()) …
//
// The header is read here and not by gRPC's AuthMetadataProcessor, which credentials without
// encryption do not have: loopback takes the same way.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "server/security/authenticator.h"
#include "server/security/caller.h"
#include "server/security/connection_table.h"
#include "server/security/live_calls.h"

namespace penumbra {

// For the operator's records. It holds no credential.
struct RefusedCall {
  std::string_view call;
  std::string peer;
  std::string why;
};

class CallGuard {
 public:
  using OnRefused = std::function<void(const RefusedCall&)>;

  CallGuard(const Authenticator& authenticator, ConnectionTable& connections, LiveCalls& calls,
            OnRefused on_refused)
      : authenticator_(authenticator),
        connections_(connections),
        calls_(calls),
        on_refused_(std::move(on_refused)) {}

  // Errors  kUnauthenticated UNAUTHENTICATED, in one text whatever the cause;
  //         kPermissionDenied ROLE
  absl::StatusOr<Caller> Admit(const grpc::CallbackServerContext& context,
                               std::string_view name) const;

  // Ends the stream `context` once its caller's right ends: by `end`, which is given a status, or
  // where that is null by cancelling. The caller of this calls Finish before the context is gone.
  std::shared_ptr<LiveCall> Follow(const Caller& caller, LiveCall::End end,
                                   grpc::CallbackServerContext* context) const;

 private:
  absl::Status StillAllows(Caller& caller) const;

  const Authenticator& authenticator_;
  ConnectionTable& connections_;
  LiveCalls& calls_;
  const OnRefused on_refused_;
};

}  // namespace penumbra
