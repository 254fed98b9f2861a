#include "server/security/call_guard.h"

#include <grpc/grpc_security_constants.h>

#include <utility>

#include "grpcpp/security/auth_context.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr char kHeader[] = "authorization";

std::string ToString(grpc::string_ref text) { return {text.data(), text.size()}; }

PresentedCredentials CredentialsOf(const grpc::CallbackServerContext& context) {
  PresentedCredentials shown;
  const auto [first, last] = context.client_metadata().equal_range(kHeader);
  for (auto value = first; value != last; ++value) {
    shown.authorizations.push_back(ToString(value->second));
  }
  const auto peer = context.auth_context();
  if (!peer) return shown;
  for (const auto& [property, prefix] : {std::pair(GRPC_X509_CN_PROPERTY_NAME, "cn:"),
                                         std::pair(GRPC_PEER_DNS_PROPERTY_NAME, "dns:"),
                                         std::pair(GRPC_PEER_URI_PROPERTY_NAME, "uri:")}) {
    for (const auto& name : peer->FindPropertyValues(property)) {
      shown.certificate_names.push_back(prefix + ToString(name));
    }
  }
  return shown;
}

absl::Status Unauthenticated() {
  return FieldError(absl::StatusCode::kUnauthenticated, "UNAUTHENTICATED", "authorization",
                    "found no valid credentials, need a bearer token or a client certificate that "
                    "this server accepts");
}

}  // namespace

absl::StatusOr<Caller> CallGuard::Admit(const grpc::CallbackServerContext& context,
                                        std::string_view name) const {
  PresentedCredentials shown = CredentialsOf(context);
  const uint64_t version = authenticator_.version();
  auto identity = authenticator_.Authenticate(shown);
  if (!identity.ok()) {
    const std::string why(identity.status().message());
    if (on_refused_) on_refused_(RefusedCall{.call = name, .peer = context.peer(), .why = why});
    return Unauthenticated();
  }
  connections_.OnAdmitted(context.peer());
  Caller caller(*std::move(identity), std::move(shown), version);
  if (auto status = caller.Authorize(name); !status.ok()) return status;
  return caller;
}

absl::Status CallGuard::StillAllows(Caller& caller) const {
  const uint64_t version = authenticator_.version();
  const auto& expires = caller.identity_.expires;
  const bool is_as_before = version == caller.version_;
  if (is_as_before && (!expires || authenticator_.now() < *expires)) return absl::OkStatus();
  auto identity = authenticator_.Authenticate(caller.shown_);
  if (!identity.ok()) return Unauthenticated();
  // What was decided by other rights is decided anew: the client has to call again.
  if (identity->role != caller.identity_.role || identity->scope != caller.identity_.scope) {
    return Unauthenticated();
  }
  caller.identity_ = *std::move(identity);
  caller.version_ = version;
  return absl::OkStatus();
}

std::shared_ptr<LiveCall> CallGuard::Follow(const Caller& caller, LiveCall::End end,
                                            grpc::CallbackServerContext* context) const {
  return calls_.Add([this, caller = Caller(caller)]() mutable { return StillAllows(caller); },
                    std::move(end), context);
}

}  // namespace penumbra
