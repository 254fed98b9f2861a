// JSON Web Tokens of an identity provider, checked (RFC 7519, RFC 8725).
//
//   auto identity = VerifyJwt(token, keys, {.issuer = "https://id.example", .audience = "penumbra"},
//                             now);
//
// What is read of a token's claims: "iss", "aud", "exp" and, if there, "nbf"; "sub" is the name,
// "penumbra_role" the role, and "penumbra_scenes" the scope, a list of patterns or one text with
// blanks between them.
//
// Signatures are checked by OpenSSL; the envelope is our own. Of Debian 12's libraries for it,
// libjwt 1.10 lets the token's header choose the algorithm, and cpp-jwt 1.4 decodes what is no
// base64, indexes a table by a signed character, and subtracts the skew from an unsigned number.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/security/identity.h"
#include "server/security/jwt_keys.h"

namespace penumbra {

struct JwtRules {
  std::string issuer;
  std::string audience;
  std::chrono::seconds skew{60};  // by which clocks may differ, both ways
};

// Whether `text` can be a JWT at all: three parts between dots.
bool LooksLikeJwt(std::string_view text);

// Errors  kUnauthenticated: why, for the server's records and for nobody else
absl::StatusOr<Identity> VerifyJwt(std::string_view token, const JwtKeys& keys,
                                   const JwtRules& rules,
                                   std::chrono::system_clock::time_point now);

}  // namespace penumbra
