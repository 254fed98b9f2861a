#include "tests/support/jwt_signer.h"

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ec.h>
#include <openssl/ecdsa.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/pem.h>
#include <openssl/rsa.h>

#include <utility>

#include "absl/strings/escaping.h"

namespace penumbra::testing {
namespace {

std::string NumberOf(EVP_PKEY* key, const char* name, int size = 0) {
  BIGNUM* number = nullptr;
  EVP_PKEY_get_bn_param(key, name, &number);
  std::string bytes(static_cast<size_t>(size ? size : BN_num_bytes(number)), '\0');
  BN_bn2binpad(number, reinterpret_cast<unsigned char*>(bytes.data()),
               static_cast<int>(bytes.size()));
  BN_free(number);
  return absl::WebSafeBase64Escape(bytes);
}

std::string RawFromDer(const std::string& der) {
  const auto* at = reinterpret_cast<const unsigned char*>(der.data());
  ECDSA_SIG* pair = d2i_ECDSA_SIG(nullptr, &at, static_cast<long>(der.size()));
  std::string raw(64, '\0');
  auto* out = reinterpret_cast<unsigned char*>(raw.data());
  BN_bn2binpad(ECDSA_SIG_get0_r(pair), out, 32);
  BN_bn2binpad(ECDSA_SIG_get0_s(pair), out + 32, 32);
  ECDSA_SIG_free(pair);
  return raw;
}

}  // namespace

JwtSigner::JwtSigner(std::string key_id, std::string algorithm, evp_pkey_st* key)
    : key_id_(std::move(key_id)), algorithm_(std::move(algorithm)), key_(key, EVP_PKEY_free) {}

JwtSigner JwtSigner::Rsa(const std::string& key_id, unsigned bits) {
  return JwtSigner(key_id, "RS256", EVP_RSA_gen(bits));
}

JwtSigner JwtSigner::Ec(const std::string& key_id) {
  return JwtSigner(key_id, "ES256", EVP_EC_gen("P-256"));
}

nlohmann::json JwtSigner::Jwk() const {
  EVP_PKEY* key = key_.get();
  if (algorithm_ == "RS256") {
    return {{"kty", "RSA"},
            {"kid", key_id_},
            {"n", NumberOf(key, OSSL_PKEY_PARAM_RSA_N)},
            {"e", NumberOf(key, OSSL_PKEY_PARAM_RSA_E)}};
  }
  return {{"kty", "EC"},
          {"crv", "P-256"},
          {"kid", key_id_},
          {"x", NumberOf(key, OSSL_PKEY_PARAM_EC_PUB_X, 32)},
          {"y", NumberOf(key, OSSL_PKEY_PARAM_EC_PUB_Y, 32)}};
}

std::string JwtSigner::KeySet() const { return KeySetOf({*this}); }

std::string JwtSigner::PublicPem() const {
  BIO* out = BIO_new(BIO_s_mem());
  PEM_write_bio_PUBKEY(out, key_.get());
  char* text = nullptr;
  const long size = BIO_get_mem_data(out, &text);
  std::string pem(text, static_cast<size_t>(size));
  BIO_free(out);
  return pem;
}

std::string JwtSigner::Signature(const std::string& algorithm, const std::string& message) const {
  const auto* bytes = reinterpret_cast<const unsigned char*>(message.data());
  if (algorithm == "none") return "";
  if (algorithm == "HS256") {
    const std::string secret = PublicPem();
    std::string code(32, '\0');
    unsigned size = 32;
    HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()), bytes, message.size(),
         reinterpret_cast<unsigned char*>(code.data()), &size);
    return code;
  }
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  EVP_DigestSignInit(context, nullptr, EVP_sha256(), nullptr, key_.get());
  size_t size = 0;
  EVP_DigestSign(context, nullptr, &size, bytes, message.size());
  std::string signature(size, '\0');
  EVP_DigestSign(context, reinterpret_cast<unsigned char*>(signature.data()), &size, bytes,
                 message.size());
  EVP_MD_CTX_free(context);
  signature.resize(size);
  return algorithm_ == "ES256" ? RawFromDer(signature) : signature;
}

std::string JwtSigner::Sign(const nlohmann::json& claims) const {
  return SignAs({{"alg", algorithm_}, {"kid", key_id_}, {"typ", "JWT"}}, claims);
}

std::string JwtSigner::SignAs(const nlohmann::json& header, const nlohmann::json& claims) const {
  const std::string message =
      absl::WebSafeBase64Escape(header.dump()) + "." + absl::WebSafeBase64Escape(claims.dump());
  return message + "." +
         absl::WebSafeBase64Escape(Signature(header.value("alg", algorithm_), message));
}

std::string JwtSigner::SignText(const std::string& header, const std::string& claims) const {
  const std::string message =
      absl::WebSafeBase64Escape(header) + "." + absl::WebSafeBase64Escape(claims);
  return message + "." + absl::WebSafeBase64Escape(Signature(algorithm_, message));
}

std::string KeySetOf(const std::vector<JwtSigner>& signers) {
  nlohmann::json keys = nlohmann::json::array();
  for (const JwtSigner& signer : signers) keys.push_back(signer.Jwk());
  return nlohmann::json{{"keys", keys}}.dump();
}

}  // namespace penumbra::testing
