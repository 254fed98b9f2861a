// Signs JWTs as an identity provider does, and as somebody does who forges them.
//
//   const JwtSigner signer = JwtSigner::Rsa("key-1");
//   signer.KeySet();                                   // for --jwt-keys
//   signer.Sign({{"sub", "ana"}, …});
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

struct evp_pkey_st;

namespace penumbra::testing {

class JwtSigner {
 public:
  static JwtSigner Rsa(const std::string& key_id, unsigned bits = 2048);
  static JwtSigner Ec(const std::string& key_id);

  nlohmann::json Jwk() const;
  std::string KeySet() const;  // of this key alone
  // The public key, in PEM: what a forger uses as a shared secret.
  std::string PublicPem() const;

  std::string Sign(const nlohmann::json& claims) const;
  // With a header of the caller's; "alg" there says how it is signed: RS256, ES256, HS256 with the
  // public key as the secret, or none.
  std::string SignAs(const nlohmann::json& header, const nlohmann::json& claims) const;
  // By the key's own algorithm, whatever the texts are.
  std::string SignText(const std::string& header, const std::string& claims) const;

 private:
  JwtSigner(std::string key_id, std::string algorithm, evp_pkey_st* key);
  std::string Signature(const std::string& algorithm, const std::string& message) const;

  std::string key_id_;
  std::string algorithm_;
  std::shared_ptr<evp_pkey_st> key_;
};

std::string KeySetOf(const std::vector<JwtSigner>& signers);

}  // namespace penumbra::testing
