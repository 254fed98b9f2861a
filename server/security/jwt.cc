#include "server/security/jwt.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "server/security/base64url.h"
#include "server/security/split.h"

namespace penumbra {
namespace {

using Json = nlohmann::json;
using Time = std::chrono::system_clock::time_point;

// Seconds from 1970 that a time point can hold: up to the year 2200.
constexpr double kLatestSecond = 7'258'118'400.0;

absl::Status Refused(const char* why) { return absl::UnauthenticatedError(why); }

// The part as a JSON object; nothing for anything else.
std::optional<Json> ReadObject(std::string_view part) {
  const auto text = DecodeBase64Url(part);
  if (!text) return std::nullopt;
  Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return std::nullopt;
  return json;
}

std::optional<std::string> TextAt(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

std::optional<Time> TimeAt(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  const double seconds = found->get<double>();
  if (!(seconds >= 0.0 && seconds <= kLatestSecond)) return std::nullopt;
  return Time(std::chrono::seconds(static_cast<int64_t>(seconds)));
}

bool IsFor(const Json& claims, const std::string& audience) {
  const auto found = claims.find("aud");
  if (found == claims.end()) return false;
  if (found->is_array()) return std::find(found->begin(), found->end(), audience) != found->end();
  return *found == audience;
}

absl::StatusOr<SceneScope> ScopeOf(const Json& claims) {
  std::vector<std::string> patterns;
  const auto found = claims.find("penumbra_scenes");
  if (found != claims.end() && found->is_string()) {
    const std::string text = found->get<std::string>();
    for (const std::string_view pattern : SplitWords(text, " ")) patterns.emplace_back(pattern);
  } else if (found != claims.end() && found->is_array()) {
    for (const Json& pattern : *found) {
      if (!pattern.is_string()) return Refused("a scene pattern that is no text");
      patterns.push_back(pattern.get<std::string>());
    }
  }
  return SceneScope::Create(std::move(patterns));
}

absl::Status CheckTimes(const Json& claims, const JwtRules& rules, Time now) {
  const auto expires = TimeAt(claims, "exp");
  if (!expires) return Refused("no time of expiry");
  if (now >= *expires + rules.skew) return Refused("expired");
  if (!claims.contains("nbf")) return absl::OkStatus();
  const auto not_before = TimeAt(claims, "nbf");
  if (!not_before) return Refused("a time before which it is not valid that is none");
  if (now < *not_before - rules.skew) return Refused("not yet valid");
  return absl::OkStatus();
}

absl::StatusOr<Identity> ReadClaims(const Json& claims, const JwtRules& rules, Time now) {
  if (TextAt(claims, "iss") != rules.issuer) return Refused("another issuer");
  if (!IsFor(claims, rules.audience)) return Refused("another audience");
  if (auto status = CheckTimes(claims, rules, now); !status.ok()) return status;
  const auto subject = TextAt(claims, "sub");
  if (!subject || subject->empty() || subject->size() > 256) return Refused("no subject");
  const auto role = RoleNamed(TextAt(claims, "penumbra_role").value_or(""));
  if (!role) return Refused("no role");
  auto scope = ScopeOf(claims);
  if (!scope.ok()) return Refused("no scenes");
  return Identity{.name = *subject,
                  .role = *role,
                  .scope = *std::move(scope),
                  .expires = *TimeAt(claims, "exp") + rules.skew};
}

}  // namespace

bool LooksLikeJwt(std::string_view text) { return std::count(text.begin(), text.end(), '.') == 2; }

absl::StatusOr<Identity> VerifyJwt(std::string_view token, const JwtKeys& keys,
                                   const JwtRules& rules, Time now) {
  const auto parts = Split(token, ".");
  if (parts.size() != 3) return Refused("not three parts");
  const auto header = ReadObject(parts[0]);
  if (!header) return Refused("no header");
  // Extensions that have to be understood; none is.
  if (header->contains("crit")) return Refused("a critical header");
  const auto key_id = TextAt(*header, "kid");
  const JwtKey* key = key_id ? keys.Find(*key_id) : nullptr;
  if (!key) return Refused("an unknown key");
  if (TextAt(*header, "alg") != JwtAlgorithmName(key->algorithm())) {
    return Refused("another algorithm than its key's");
  }
  const auto signature = DecodeBase64Url(parts[2]);
  const std::string_view message = token.substr(0, parts[0].size() + 1 + parts[1].size());
  if (!signature || !key->Verifies(message, *signature)) return Refused("a wrong signature");
  const auto claims = ReadObject(parts[1]);
  if (!claims) return Refused("no claims");
  return ReadClaims(*claims, rules, now);
}

}  // namespace penumbra
