#include "server/security/authenticator.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/string_view.h"
#include "render/scene/field_error.h"
#include "server/security/bearer_token.h"
#include "server/security/small_file.h"

namespace penumbra {
namespace {

constexpr absl::string_view kScheme = "Bearer ";

absl::Status Refused(const char* why) { return absl::UnauthenticatedError(why); }

absl::Status CheckRules(const AuthenticatorOptions& options) {
  if (options.jwt_keys_file.empty()) return absl::OkStatus();
  for (const auto& [name, value] : {std::pair("jwt-issuer", options.jwt.issuer),
                                    std::pair("jwt-audience", options.jwt.audience)}) {
    if (!value.empty()) continue;
    return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", name,
                      "found none, need it with --jwt-keys: others sign with the same keys");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<Authenticator>> Authenticator::Create(AuthenticatorOptions options) {
  if (auto status = CheckRules(options); !status.ok()) return status;
  std::unique_ptr<Authenticator> authenticator(new Authenticator(std::move(options)));
  const auto texts = authenticator->Read();
  if (!texts.ok()) return texts.status();
  authenticator->seen_ = *texts;
  if (auto status = authenticator->Take(*texts); !status.ok()) return status;
  return authenticator;
}

absl::StatusOr<Authenticator::Texts> Authenticator::Read() const {
  Texts texts;
  for (const auto& [path, option, text] :
       {std::tuple(&options_.tokens_file, "tokens", &texts.tokens),
        std::tuple(&options_.jwt_keys_file, "jwt-keys", &texts.keys)}) {
    if (path->empty()) continue;
    auto read = ReadSmallFile(*path, option);
    if (!read.ok()) return read.status();
    *text = *std::move(read);
  }
  return texts;
}

absl::Status Authenticator::Take(const Texts& texts) {
  taken_ = texts;
  auto known = std::make_shared<Known>();
  auto identities = IdentityFile::Parse(texts.tokens);
  if (!identities.ok()) return identities.status();
  known->identities = *std::move(identities);
  if (!options_.jwt_keys_file.empty()) {
    auto keys = JwtKeys::Parse(texts.keys);
    if (!keys.ok()) return keys.status();
    known->keys = *std::move(keys);
  }
  std::lock_guard lock(mutex_);
  known_ = std::move(known);
  ++version_;
  return absl::OkStatus();
}

absl::Status Authenticator::Reload() {
  if (is_open()) return absl::OkStatus();
  auto texts = Read();
  if (!texts.ok()) return texts.status();
  const bool has_settled = *texts == seen_;
  seen_ = *texts;
  if (!has_settled || *texts == taken_) return absl::OkStatus();
  return Take(*texts);
}

std::shared_ptr<const Authenticator::Known> Authenticator::known() const {
  std::lock_guard lock(mutex_);
  return known_;
}

absl::StatusOr<Identity> Authenticator::AuthenticateText(const std::string& authorization,
                                                         const Known& known) const {
  if (!absl::StartsWithIgnoreCase(authorization, kScheme)) return Refused("no bearer token");
  const std::string_view token = std::string_view(authorization).substr(kScheme.size());
  if (IsBearerToken(token)) {
    const Identity* identity = known.identities.FindToken(token);
    if (!identity) return Refused("an unknown token");
    return *identity;
  }
  if (known.keys.size() == 0 || !LooksLikeJwt(token)) return Refused("a malformed token");
  return VerifyJwt(token, known.keys, options_.jwt, options_.now());
}

absl::StatusOr<Identity> Authenticator::Authenticate(const PresentedCredentials& shown) const {
  if (is_open()) return LocalAdmin();
  const auto known = this->known();
  absl::StatusOr<Identity> identity = Refused("no credentials");
  if (shown.authorizations.size() == 1) {
    identity = AuthenticateText(shown.authorizations.front(), *known);
  } else if (shown.authorizations.size() > 1) {
    identity = Refused("more than one token");
  } else if (!shown.certificate_names.empty()) {
    const Identity* found = known->identities.FindCertificate(shown.certificate_names);
    identity = found ? absl::StatusOr<Identity>(*found) : Refused("an unknown certificate");
  }
  if (identity.ok() && identity->expires && options_.now() >= *identity->expires) {
    return Refused("expired");
  }
  return identity;
}

}  // namespace penumbra
