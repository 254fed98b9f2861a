#include "server/security/identity_file.h"

#include <openssl/crypto.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"
#include "server/security/bearer_token.h"
#include "server/security/split.h"

namespace penumbra {
namespace {

// Every call compares its token with all of them: 20 µs.
constexpr size_t kMaxIdentities = 1'024;
constexpr std::string_view kHashPrefix = "sha256:";

absl::Status Bad(const std::string& text) { return absl::InvalidArgumentError(text); }

absl::StatusOr<Identity> ReadIdentity(const std::vector<std::string>& words) {
  Identity identity;
  identity.name = words[2];
  if (auto status = CheckId(identity.name, "name"); !status.ok()) return status;
  const auto role = RoleNamed(words[3]);
  if (!role) return Bad(absl::StrCat("found role '", words[3], "', need viewer, editor or admin"));
  identity.role = *role;
  const auto patterns = Split(words[4], ",");
  auto scope = SceneScope::Create({patterns.begin(), patterns.end()});
  if (!scope.ok()) return scope.status();
  identity.scope = *std::move(scope);
  if (words.size() > 5) {
    absl::Time expires;
    std::string error;
    if (!absl::ParseTime(absl::RFC3339_full, words[5], &expires, &error)) {
      return Bad(absl::StrCat("found '", words[5], "', need a time such as 2027-01-31T00:00:00Z"));
    }
    identity.expires = absl::ToChronoTime(expires);
  }
  return identity;
}

bool IsCertificateName(std::string_view text) {
  for (const std::string_view prefix : {"cn:", "dns:", "uri:"}) {
    if (text.starts_with(prefix)) return text.size() > prefix.size();
  }
  return false;
}

}  // namespace

absl::Status IdentityFile::AddLine(std::string_view line) {
  const auto parts = SplitWords(line, " \t\r");
  const std::vector<std::string> words(parts.begin(), parts.end());
  if (words.empty() || words[0].starts_with('#')) return absl::OkStatus();
  if (words.size() < 5 || words.size() > 6) {
    return Bad(absl::StrCat("found ", words.size(),
                            " words, need: kind, what they show, name, role, scenes and perhaps a "
                            "time"));
  }
  auto identity = ReadIdentity(words);
  if (!identity.ok()) return identity.status();
  if (size() >= kMaxIdentities) {
    return Bad(absl::StrCat("found another identity, need at most ", kMaxIdentities));
  }
  if (words[0] == "token") {
    const auto hash =
        words[1].starts_with(kHashPrefix)
            ? ContentHash::FromHex(std::string_view(words[1]).substr(kHashPrefix.size()))
            : std::nullopt;
    if (!hash) return Bad("found a token without its hash, need sha256: and 64 hex digits");
    const bool is_twice = std::any_of(tokens_.begin(), tokens_.end(),
                                      [&](const Token& token) { return token.hash == *hash; });
    if (is_twice) return Bad("found a token for the second time, need it once");
    tokens_.push_back({*hash, *std::move(identity)});
    return absl::OkStatus();
  }
  if (words[0] != "certificate") {
    return Bad(absl::StrCat("found '", words[0], "', need token or certificate"));
  }
  if (!IsCertificateName(words[1])) {
    return Bad(absl::StrCat("found '", words[1], "', need cn:, dns: or uri: and a name"));
  }
  const bool is_twice = std::any_of(certificates_.begin(), certificates_.end(),
                                    [&](const Certificate& c) { return c.name == words[1]; });
  if (is_twice) return Bad("found a certificate for the second time, need it once");
  certificates_.push_back({words[1], *std::move(identity)});
  return absl::OkStatus();
}

absl::StatusOr<IdentityFile> IdentityFile::Parse(std::string_view text) {
  IdentityFile file;
  size_t number = 0;
  for (const std::string_view line : Split(text, "\n")) {
    ++number;
    if (auto status = file.AddLine(line); !status.ok()) {
      return FieldError(absl::StatusCode::kInvalidArgument, "BAD_IDENTITY",
                        absl::StrCat("tokens:", number), std::string(status.message()));
    }
  }
  return file;
}

const Identity* IdentityFile::FindToken(std::string_view token) const {
  const ContentHash hash = HashOfToken(token);
  const Identity* found = nullptr;
  for (const Token& known : tokens_) {
    if (CRYPTO_memcmp(known.hash.bytes.data(), hash.bytes.data(), hash.bytes.size()) == 0) {
      found = &known.identity;
    }
  }
  return found;
}

const Identity* IdentityFile::FindCertificate(std::span<const std::string> names) const {
  for (const Certificate& known : certificates_) {
    if (std::find(names.begin(), names.end(), known.name) != names.end()) return &known.identity;
  }
  return nullptr;
}

}  // namespace penumbra
