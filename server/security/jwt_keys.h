// The keys that sign the JWTs which a server accepts: a JSON Web Key Set (RFC 7517), as identity
// providers publish it.
//
// A key belongs to one algorithm, by its kind: RSA of 2,048 bits and more to RS256, P-256 to ES256.
// What a token's header says never chooses how it is checked, so that no token can have a public
// key used as a shared secret.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

struct evp_pkey_st;

namespace penumbra {

enum class JwtAlgorithm { kRs256, kEs256 };

constexpr std::string_view JwtAlgorithmName(JwtAlgorithm algorithm) {
  return algorithm == JwtAlgorithm::kRs256 ? "RS256" : "ES256";
}

class JwtKey {
 public:
  JwtKey(JwtAlgorithm algorithm, std::shared_ptr<evp_pkey_st> key)
      : algorithm_(algorithm), key_(std::move(key)) {}

  JwtAlgorithm algorithm() const { return algorithm_; }
  // `signature` as RFC 7518 §3 has it: of ES256 64 bytes, r and s.
  bool Verifies(std::string_view message, std::string_view signature) const;

 private:
  JwtAlgorithm algorithm_;
  std::shared_ptr<evp_pkey_st> key_;
};

class JwtKeys {
 public:
  // Errors  kInvalidArgument BAD_KEY, field "jwt-keys.keys[2].n": which key, and what is wrong
  static absl::StatusOr<JwtKeys> Parse(std::string_view json);

  // Null when there is none of that id.
  const JwtKey* Find(std::string_view key_id) const;
  size_t size() const { return keys_.size(); }

 private:
  std::map<std::string, JwtKey, std::less<>> keys_;
};

}  // namespace penumbra
