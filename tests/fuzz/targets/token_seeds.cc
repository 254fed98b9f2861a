#include "tests/fuzz/targets/token_seeds.h"

#include "server/security/bearer_token.h"

namespace penumbra::fuzzing {
namespace {

// With keys that nobody has the other half of: the largest number of 2,048 bits, and the point that
// P-256 begins with.
std::string KeySet() {
  const Json rsa = {
      {"kty", "RSA"}, {"kid", "rsa"}, {"n", std::string(341, '_') + "w"}, {"e", "AQAB"}};
  const Json ec = {{"kty", "EC"},
                   {"crv", "P-256"},
                   {"kid", "ec"},
                   {"use", "sig"},
                   {"x", "axfR8uEsQkf4vOblY6RA8ncDfYEt6zOg9KE5RdiYwpY"},
                   {"y", "T-NC4v4af5uO5-tKfA-eFivOM1drMV7Oy7ZAaDe_UfU"}};
  return Json{{"keys", {rsa, ec}}}.dump();
}

std::string Identities() {
  std::string text = "# kind  what they show  name  role  scenes  until\n\n";
  for (const std::string& token : BearerTokens()) {
    text += "token sha256:" + HashOfToken(token).hex() + " ana editor review-*,studio\n";
  }
  return text + "certificate cn:render-01 farm viewer * 2027-01-31T00:00:00Z\n";
}

}  // namespace

Json SoundClaims() {
  return {{"iss", kIssuer},       {"aud", kAudience},          {"exp", kNow + 600},
          {"sub", "ana@example"}, {"penumbra_role", "editor"}, {"penumbra_scenes", "review-* a"}};
}

const std::array<std::string, 2>& BearerTokens() {
  static const std::array<std::string, 2> tokens = {"penumbra_" + std::string(43, 'A'),
                                                    "penumbra_" + std::string(42, 'B') + 'E'};
  return tokens;
}

std::vector<Seed> TokenSeeds() {
  Json lists = SoundClaims();
  lists["aud"] = {"others", kAudience};
  lists["nbf"] = kNow - 5;
  lists["penumbra_scenes"] = {"review-*", "*-b"};
  const std::string of_rsa = R"({"alg":"RS256","kid":"rsa","typ":"JWT"})";
  return {
      {"claims", {{kClaims, SoundClaims().dump()}, {kClaims, lists.dump()}}},
      {"rsa", {{kHeader, of_rsa}, {kClaims, lists.dump()}}},
      {"changed", {{kClaims, SoundClaims().dump()}, {kChange, std::string("\x20\x00\x01", 3)}}},
      {"forged", {{kAlgorithm, "HS256"}, {kAlgorithm, "none"}, {kAlgorithm, "ES256"}}},
      {"unsigned", {{kToken, "eyJhbGciOiJub25lIiwia2lkIjoiZWMifQ.e30."}}},
      {"keys", {{kKeySet, KeySet()}}},
      {"bearer", {{kBearer, BearerTokens()[0]}, {kBearer, BearerTokens()[1]}}},
      {"identities", {{kIdentities, Identities()}}},
  };
}

}  // namespace penumbra::fuzzing
