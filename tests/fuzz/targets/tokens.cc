// What callers show and what operators write of who they are: JWTs, key sets, bearer tokens and
// files of identities. Nobody is let in by a token that was not signed just so, and whoever is let
// in is who the signed claims, or the file, say.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "render/scene/scene.h"
#include "server/security/bearer_token.h"
#include "server/security/identity_file.h"
#include "server/security/jwt.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/kit/target.h"
#include "tests/fuzz/targets/payload_numbers.h"
#include "tests/fuzz/targets/token_seeds.h"
#include "tests/support/jwt_signer.h"

namespace penumbra::fuzzing {
namespace {

using testing::JwtSigner;
using Time = std::chrono::system_clock::time_point;

constexpr double kSkewSeconds = 60;
const Time kTime{std::chrono::seconds(kNow)};

const JwtRules& Rules() {
  static const JwtRules rules = {.issuer = kIssuer, .audience = kAudience};
  return rules;
}

const JwtSigner& RsaSigner() {
  static const JwtSigner signer = JwtSigner::Rsa("rsa");
  return signer;
}
const JwtSigner& EcSigner() {
  static const JwtSigner signer = JwtSigner::Ec("ec");
  return signer;
}
const JwtKeys& Keys() {
  static const JwtKeys keys = JwtKeys::Parse(testing::KeySetOf({RsaSigner(), EcSigner()})).value();
  return keys;
}

// By what each beginning of the pattern matches.
bool MatchesAnew(std::string_view pattern, std::string_view text) {
  std::vector<char> ends(text.size() + 1, 0);  // whether the pattern so far matches so much
  ends[0] = 1;
  for (const char c : pattern) {
    if (c == '*') {
      for (size_t i = 1; i <= text.size(); ++i) ends[i] = ends[i] || ends[i - 1];
      continue;
    }
    for (size_t i = text.size(); i > 0; --i) ends[i] = ends[i - 1] && text[i - 1] == c;
    ends[0] = 0;
  }
  return ends[text.size()] != 0;
}

void CheckScope(const SceneScope& scope) {
  Require(!scope.patterns().empty() && scope.patterns().size() <= 64, "a scope has patterns");
  for (const std::string_view id : {"a", "studio", "review-7", "x.review-", "a_b-c", "aaaaaaab"}) {
    const bool matches = std::ranges::any_of(
        scope.patterns(), [&](const std::string& pattern) { return MatchesAnew(pattern, id); });
    Require(scope.Contains(id) == matches, "a scope has what its patterns match");
  }
}

std::vector<std::string> PatternsIn(const Json& scenes) {
  if (scenes.is_array()) return scenes.get<std::vector<std::string>>();
  std::vector<std::string> patterns(1);
  for (const char c : scenes.get<std::string>()) {
    if (c != ' ') {
      patterns.back() += c;
    } else if (!patterns.back().empty()) {
      patterns.emplace_back();
    }
  }
  if (patterns.back().empty()) patterns.pop_back();
  return patterns;
}

// The claims of a token that was let in.
void CheckClaims(const Json& claims, const Identity& identity) {
  Require(claims.is_object() && claims.at("iss") == Rules().issuer, "the issuer is ours");
  const Json& audience = claims.at("aud");
  Require(audience == Rules().audience ||
              (audience.is_array() && std::find(audience.begin(), audience.end(),
                                                Json(Rules().audience)) != audience.end()),
          "the token is for us");
  Require(std::floor(claims.at("exp").get<double>()) + kSkewSeconds > kNow, "it has not expired");
  Require(
      !claims.contains("nbf") || std::floor(claims.at("nbf").get<double>()) - kSkewSeconds <= kNow,
      "it is valid already");
  Require(claims.at("sub") == identity.name && !identity.name.empty(), "the name is the subject");
  Require(claims.at("penumbra_role") == std::string(RoleName(identity.role)), "the role is named");
  Require(PatternsIn(claims.at("penumbra_scenes")) == identity.scope.patterns(),
          "the scenes are those of the claims");
  CheckScope(identity.scope);
}

absl::StatusOr<Identity> Verify(const std::string& token) {
  auto identity = VerifyJwt(token, Keys(), Rules(), kTime);
  Require(identity.ok() || absl::IsUnauthenticated(identity.status()),
          "whoever is not let in is not known");
  Require(!identity.ok() || LooksLikeJwt(token), "a token looks like one");
  return identity;
}

void Forge(const std::string& algorithm) {
  if (!std::ranges::all_of(algorithm, [](char c) { return static_cast<int8_t>(c) >= 0; })) return;
  for (const JwtSigner* signer : {&RsaSigner(), &EcSigner()}) {
    const bool is_rsa = signer == &RsaSigner();
    const std::string own = is_rsa ? "RS256" : "ES256", id = is_rsa ? "rsa" : "ec";
    const std::string token = signer->SignAs({{"alg", algorithm}, {"kid", id}}, SoundClaims());
    Require(Verify(token).ok() == (algorithm == own), "a key has one algorithm");
  }
}

// 43 letters of 6 bits hold 256 bits, and two that are 0.
bool IsBearerAnew(std::string_view text) {
  constexpr std::string_view kPrefix = "penumbra_",
                             kAlphabet =
                                 "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
  if (!text.starts_with(kPrefix) || text.size() != kPrefix.size() + 43) return false;
  text.remove_prefix(kPrefix.size());
  return text.find_first_not_of(kAlphabet) == std::string_view::npos &&
         kAlphabet.find(text.back()) % 4 == 0;
}

std::string LowerCase(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

class Tokens final : public Target {
 public:
  std::span<const StepKind> kinds() const override { return kinds_; }
  void Run(const Script& script) override;
  std::vector<Seed> Seeds() override { return TokenSeeds(); }

 private:
  void Take(const Step& step);
  void Sign(const std::string& claims);
  void Change(PayloadNumbers numbers) const;
  void ReadKeySet(const std::string& text);
  void ReadIdentities(const std::string& text);

  const StepKind kinds_[kTokenKinds] = {{"header"}, {"claims"},  {"change"}, {"algorithm"},
                                        {"token"},  {"key set"}, {"bearer"}, {"identities"}};
  // Of the script that runs.
  std::string header_;
  std::string signed_;
};

void Tokens::Run(const Script& script) {
  header_ = R"({"alg":"ES256","kid":"ec"})";
  signed_ = EcSigner().Sign(SoundClaims());
  for (const Step& step : script) Take(step);
}

void Tokens::Take(const Step& step) {
  switch (step.kind % kTokenKinds) {
    case kHeader:
      header_ = step.payload;
      return;
    case kClaims:
      return Sign(step.payload);
    case kChange:
      return Change(PayloadNumbers(step.payload));
    case kAlgorithm:
      return Forge(step.payload);
    case kToken:
      return Require(!Verify(step.payload).ok(), "what nobody has signed lets nobody in");
    case kKeySet:
      return ReadKeySet(step.payload);
    case kBearer:
      return Require(IsBearerToken(step.payload) == IsBearerAnew(step.payload),
                     "bearer tokens are of one form");
    case kIdentities:
      return ReadIdentities(step.payload);
  }
}

void Tokens::Sign(const std::string& claims) {
  const bool is_rsa = header_.find("rsa") != std::string::npos;
  signed_ = (is_rsa ? RsaSigner() : EcSigner()).SignText(header_, claims);
  const auto identity = Verify(signed_);
  Count(identity.ok());
  if (!identity.ok()) return;
  const Json header = Json::parse(header_);
  Require(header.at("alg") == (is_rsa ? "RS256" : "ES256") && !header.contains("crit") &&
              header.at("kid") == (is_rsa ? "rsa" : "ec"),
          "the header says how it is signed");
  CheckClaims(Json::parse(claims), *identity);
}

void Tokens::Change(PayloadNumbers numbers) const {
  std::string changed = signed_;
  const size_t at = numbers.Next(2) % changed.size();
  changed[at] = static_cast<char>(changed[at] ^ static_cast<char>(numbers.Next(1)));
  Require(changed == signed_ || !Verify(changed).ok(), "a changed token lets nobody in");
}

void Tokens::ReadKeySet(const std::string& text) {
  const auto keys = JwtKeys::Parse(text);
  Count(keys.ok());
  if (!keys.ok()) {
    RequireNamedRefusal(keys.status());
    return Require(ErrorReason(keys.status()) == "BAD_KEY", "a refusal of a key set");
  }
  Require(keys->size() >= 1 && keys->size() <= 64, "a key set has keys, and not too many");
  for (const JwtSigner* signer : {&RsaSigner(), &EcSigner()}) {
    Require(!VerifyJwt(signer->Sign(SoundClaims()), *keys, Rules(), kTime).ok(),
            "what another key has signed lets nobody in");
  }
}

void Tokens::ReadIdentities(const std::string& text) {
  const auto file = IdentityFile::Parse(text);
  Count(file.ok());
  if (!file.ok()) {
    RequireNamedRefusal(file.status());
    return Require(ErrorFieldPath(file.status()).starts_with("tokens:"), "the line is named");
  }
  const std::string lower = LowerCase(text);
  for (const std::string& token : BearerTokens()) {
    const std::string hash = "sha256:" + HashOfToken(token).hex();
    const Identity* const found = file->FindToken(token);
    Require(!found || lower.find(hash) != std::string::npos, "only whom the file names is known");
    Require(found || ("\n" + text).find("\ntoken " + hash + " ") == std::string::npos,
            "whom it names is known");
    Require(!file->FindToken(token + "A"), "another token is nobody's");
    if (!found) continue;
    Require(CheckId(found->name, "name").ok() && text.find(found->name) != std::string::npos,
            "a name is one of the file's");
    CheckScope(found->scope);
  }
}

}  // namespace

Target& TheTarget() {
  static Tokens target;
  return target;
}

}  // namespace penumbra::fuzzing
