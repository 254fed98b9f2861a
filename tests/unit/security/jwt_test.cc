#include "server/security/jwt.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "tests/support/jwt_signer.h"

namespace penumbra::testing {
namespace {

using Json = nlohmann::json;
using ::testing::HasSubstr;
using Time = std::chrono::system_clock::time_point;

constexpr int64_t kNow = 1'800'000'000;
const Time kTime{std::chrono::seconds(kNow)};
const JwtRules kRules = {.issuer = "https://id.example", .audience = "penumbra"};

const JwtSigner& RsaSigner() {
  static const JwtSigner signer = JwtSigner::Rsa("rsa");
  return signer;
}
const JwtSigner& EcSigner() {
  static const JwtSigner signer = JwtSigner::Ec("ec");
  return signer;
}

const JwtKeys& Keys() {
  static const JwtKeys keys = JwtKeys::Parse(KeySetOf({RsaSigner(), EcSigner()})).value();
  return keys;
}

Json Claims() {
  return {{"iss", "https://id.example"}, {"aud", "penumbra"},
          {"exp", kNow + 600},           {"sub", "ana@example"},
          {"penumbra_role", "editor"},   {"penumbra_scenes", {"review-*", "studio"}}};
}

absl::StatusOr<Identity> Verify(const std::string& token, Time now = kTime) {
  return VerifyJwt(token, Keys(), kRules, now);
}

TEST(JwtTest, BothAlgorithmsSayWhoSomeoneIs) {
  for (const JwtSigner* signer : {&RsaSigner(), &EcSigner()}) {
    const auto identity = Verify(signer->Sign(Claims()));
    ASSERT_TRUE(identity.ok()) << identity.status();
    EXPECT_EQ(identity->name, "ana@example");
    EXPECT_EQ(identity->role, Role::kEditor);
    EXPECT_TRUE(identity->scope.Contains("review-1"));
    EXPECT_FALSE(identity->scope.Contains("other"));
    EXPECT_EQ(identity->expires, kTime + std::chrono::seconds(660));
  }
}

// One claim changed; null: taken away.
std::string With(const char* name, const Json& value) {
  Json claims = Claims();
  claims.erase(name);
  if (!value.is_null()) claims[name] = value;
  return EcSigner().Sign(claims);
}

TEST(JwtTest, ScenesAndAudiencesComeInEitherForm) {
  EXPECT_TRUE(Verify(With("penumbra_scenes", "review-* studio"))->scope.Contains("studio"));
  EXPECT_TRUE(Verify(With("aud", {"others", "penumbra"})).ok());
}

TEST(JwtTest, E01ClaimsThatAreWrongAreRefused) {
  const std::tuple<const char*, Json, const char*> cases[] = {
      {"iss", nullptr, "issuer"},
      {"iss", "https://evil.example", "issuer"},
      {"iss", Json::array(), "issuer"},
      {"aud", nullptr, "audience"},
      {"aud", "others", "audience"},
      {"aud", Json::array({"others"}), "audience"},
      {"exp", nullptr, "expiry"},
      {"exp", "tomorrow", "expiry"},
      {"exp", 1e300, "expiry"},
      {"exp", -1, "expiry"},
      {"nbf", "now", "valid"},
      {"sub", nullptr, "subject"},
      {"sub", "", "subject"},
      {"sub", 7, "subject"},
      {"penumbra_role", nullptr, "role"},
      {"penumbra_role", "root", "role"},
      {"penumbra_scenes", nullptr, "scene"},
      {"penumbra_scenes", Json::array(), "scene"},
      {"penumbra_scenes", Json::array({7}), "scene"},
      {"penumbra_scenes", "a/b", "scene"},
  };
  for (const auto& [name, value, fragment] : cases) {
    const auto identity = Verify(With(name, value));
    EXPECT_EQ(identity.status().code(), absl::StatusCode::kUnauthenticated) << name << value;
    EXPECT_THAT(std::string(identity.status().message()), HasSubstr(fragment)) << name << value;
  }
}

TEST(JwtTest, E01ClocksMayDifferByAMinute) {
  EXPECT_TRUE(Verify(With("exp", kNow - 59)).ok());
  EXPECT_THAT(std::string(Verify(With("exp", kNow - 60)).status().message()), HasSubstr("expired"));
  EXPECT_TRUE(Verify(With("nbf", kNow + 60)).ok());
  EXPECT_THAT(std::string(Verify(With("nbf", kNow + 61)).status().message()),
              HasSubstr("not yet valid"));
}

TEST(JwtTest, E01WhatTheHeaderSaysDoesNotChooseTheCheck) {
  const auto refused = [](const std::string& token, const char* why) {
    const auto status = Verify(token).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kUnauthenticated) << token;
    EXPECT_THAT(std::string(status.message()), HasSubstr(why)) << token;
  };
  const JwtSigner& rsa = RsaSigner();
  refused(rsa.SignAs({{"alg", "none"}, {"kid", "rsa"}}, Claims()), "algorithm");
  refused(rsa.SignAs({{"alg", "HS256"}, {"kid", "rsa"}}, Claims()), "algorithm");
  refused(rsa.SignAs({{"alg", "RS256"}, {"kid", "ec"}}, Claims()), "algorithm");
  refused(rsa.SignAs({{"alg", "ES256"}, {"kid", "ec"}}, Claims()), "signature");
  refused(rsa.SignAs({{"alg", "RS256"}, {"kid", "unknown"}}, Claims()), "unknown key");
  refused(rsa.SignAs({{"alg", "RS256"}}, Claims()), "unknown key");
  refused(rsa.SignAs({{"alg", "RS256"}, {"kid", 7}}, Claims()), "unknown key");
  refused(rsa.SignAs({{"alg", "RS256"}, {"kid", "rsa"}, {"crit", {"exp"}}}, Claims()), "critical");
  refused(JwtSigner::Rsa("rsa").Sign(Claims()), "signature");  // another key of that name
  refused(JwtSigner::Ec("ec").Sign(Claims()), "signature");
}

TEST(JwtTest, E01ASignatureIsOfThisTextAlone) {
  for (const JwtSigner* signer : {&RsaSigner(), &EcSigner()}) {
    const std::string token = signer->Sign(Claims());
    for (size_t i = 0; i < token.size(); i += 7) {
      std::string changed = token;
      changed[i] = changed[i] == 'A' ? 'B' : 'A';
      EXPECT_FALSE(Verify(changed).ok()) << i;
    }
    EXPECT_FALSE(Verify(token + "A").ok());
    EXPECT_FALSE(Verify(token.substr(0, token.rfind('.') + 1)).ok());
    const std::string zeros = absl::WebSafeBase64Escape(std::string(64, '\0'));
    EXPECT_FALSE(Verify(token.substr(0, token.rfind('.') + 1) + zeros).ok());
  }
}

TEST(JwtTest, E01WhatIsNoTokenIsRefused) {
  const std::string deep = absl::WebSafeBase64Escape(std::string(8'000, '['));
  for (const std::string& bad :
       {std::string(), std::string(".."), std::string("..."), std::string("a.b.c"),
        absl::StrCat(absl::WebSafeBase64Escape("[]"), ".e30.AA"),
        absl::StrCat(absl::WebSafeBase64Escape("{\"alg\":"), ".e30.AA"), deep + "." + deep + ".AA",
        std::string("\xff\xfe.\x80.\x00", 7)}) {
    EXPECT_EQ(Verify(bad).status().code(), absl::StatusCode::kUnauthenticated) << bad.substr(0, 40);
  }
}

TEST(JwtKeysTest, SaysWhichKeyIsWrong) {
  Json short_key = JwtSigner::Rsa("a", 1'024).Jwk();
  Json off_curve = EcSigner().Jwk();
  off_curve["x"] = off_curve["y"];
  Json other_use = EcSigner().Jwk();
  other_use["use"] = "enc";
  Json other_algorithm = RsaSigner().Jwk();
  other_algorithm["alg"] = "HS256";
  Json nameless = EcSigner().Jwk();
  nameless.erase("kid");
  const std::tuple<Json, const char*> cases[] = {
      {short_key, "1024 bits"}, {off_curve, "P-256"},
      {other_use, "use"},       {other_algorithm, "RS256"},
      {nameless, "kid"},        {{{"kty", "oct"}, {"kid", "a"}, {"k", "c2VjcmV0"}}, "kty"},
      {Json::array(), "kid"},
  };
  for (const auto& [key, fragment] : cases) {
    const auto status = JwtKeys::Parse(Json{{"keys", {key}}}.dump()).status();
    EXPECT_EQ(ErrorReason(status), "BAD_KEY") << key;
    EXPECT_THAT(std::string(status.message()), HasSubstr(fragment)) << key;
  }
  const auto twice = Json{{"keys", {EcSigner().Jwk(), EcSigner().Jwk()}}}.dump();
  EXPECT_EQ(ErrorFieldPath(JwtKeys::Parse(twice).status()), "jwt-keys.keys[1].kid");
  for (const char* none : {"", "{}", "[]", "{\"keys\":[]}", "{\"keys\":{}}"}) {
    EXPECT_EQ(ErrorFieldPath(JwtKeys::Parse(none).status()), "jwt-keys") << none;
  }
}

}  // namespace
}  // namespace penumbra::testing
