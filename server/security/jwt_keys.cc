#include "server/security/jwt_keys.h"

#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ecdsa.h>
#include <openssl/evp.h>
#include <openssl/param_build.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "server/security/base64url.h"

namespace penumbra {
namespace {

using Json = nlohmann::json;
constexpr size_t kMaxKeys = 64;
constexpr int kMinRsaBits = 2'048;
// Verifying takes time by the square of this: longer keys would be a way to keep the server busy.
constexpr int kMaxRsaBits = 8'192;
constexpr size_t kCoordinateBytes = 32;  // of P-256

template <typename T, void (*kFree)(T*)>
struct Freed {
  void operator()(T* object) const { kFree(object); }
};
using Number = std::unique_ptr<BIGNUM, Freed<BIGNUM, BN_free>>;
using KeyContext = std::unique_ptr<EVP_PKEY_CTX, Freed<EVP_PKEY_CTX, EVP_PKEY_CTX_free>>;
using DigestContext = std::unique_ptr<EVP_MD_CTX, Freed<EVP_MD_CTX, EVP_MD_CTX_free>>;
using ParamBuilder = std::unique_ptr<OSSL_PARAM_BLD, Freed<OSSL_PARAM_BLD, OSSL_PARAM_BLD_free>>;
using Params = std::unique_ptr<OSSL_PARAM, Freed<OSSL_PARAM, OSSL_PARAM_free>>;
using Signature = std::unique_ptr<ECDSA_SIG, Freed<ECDSA_SIG, ECDSA_SIG_free>>;

const unsigned char* Bytes(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

absl::Status Bad(const std::string& field, std::string_view text) {
  return FieldError(absl::StatusCode::kInvalidArgument, "BAD_KEY", field, text);
}

std::string TextAt(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

Number NumberOf(std::string_view bytes) {
  return Number(BN_bin2bn(Bytes(bytes), static_cast<int>(bytes.size()), nullptr));
}

std::shared_ptr<EVP_PKEY> MakeKey(const char* kind, OSSL_PARAM_BLD* builder) {
  const Params params(OSSL_PARAM_BLD_to_param(builder));
  const KeyContext context(EVP_PKEY_CTX_new_from_name(nullptr, kind, nullptr));
  EVP_PKEY* key = nullptr;
  if (!params || !context || EVP_PKEY_fromdata_init(context.get()) != 1 ||
      EVP_PKEY_fromdata(context.get(), &key, EVP_PKEY_PUBLIC_KEY, params.get()) != 1) {
    return nullptr;
  }
  return {key, EVP_PKEY_free};
}

absl::StatusOr<JwtKey> ReadRsa(const Json& json, const std::string& field) {
  const auto modulus = DecodeBase64Url(TextAt(json, "n"));
  const auto exponent = DecodeBase64Url(TextAt(json, "e"));
  if (!modulus || !exponent || exponent->empty() || exponent->size() > 8 ||
      modulus->size() > kMaxRsaBits / 8) {
    return Bad(field, "found no modulus n and exponent e, need both as base64url");
  }
  const Number n = NumberOf(*modulus), e = NumberOf(*exponent);
  if (BN_num_bits(n.get()) < kMinRsaBits) {
    return Bad(field + ".n", absl::StrCat("found ", BN_num_bits(n.get()), " bits, need ",
                                          kMinRsaBits, " to ", kMaxRsaBits));
  }
  const ParamBuilder builder(OSSL_PARAM_BLD_new());
  OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_N, n.get());
  OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_E, e.get());
  auto key = MakeKey("RSA", builder.get());
  if (!key) return Bad(field, "found no RSA key, need one");
  return JwtKey(JwtAlgorithm::kRs256, std::move(key));
}

absl::StatusOr<JwtKey> ReadEc(const Json& json, const std::string& field) {
  const auto x = DecodeBase64Url(TextAt(json, "x")), y = DecodeBase64Url(TextAt(json, "y"));
  if (TextAt(json, "crv") != "P-256" || !x || !y || x->size() != kCoordinateBytes ||
      y->size() != kCoordinateBytes) {
    return Bad(field, "found another elliptic curve key, need crv P-256 with x and y of 32 bytes");
  }
  const std::string point = "\x04" + *x + *y;
  const ParamBuilder builder(OSSL_PARAM_BLD_new());
  OSSL_PARAM_BLD_push_utf8_string(builder.get(), OSSL_PKEY_PARAM_GROUP_NAME, "P-256", 0);
  OSSL_PARAM_BLD_push_octet_string(builder.get(), OSSL_PKEY_PARAM_PUB_KEY, point.data(),
                                   point.size());
  auto key = MakeKey("EC", builder.get());  // which sees whether the point is on the curve
  if (!key) return Bad(field, "found no point of P-256, need one");
  return JwtKey(JwtAlgorithm::kEs256, std::move(key));
}

absl::StatusOr<JwtKey> ReadKey(const Json& json, const std::string& field) {
  const std::string kind = TextAt(json, "kty");
  if (kind != "RSA" && kind != "EC") {
    return Bad(field + ".kty", absl::StrCat("found '", kind, "', need RSA or EC"));
  }
  auto key = kind == "RSA" ? ReadRsa(json, field) : ReadEc(json, field);
  if (!key.ok()) return key;
  if (json.contains("alg") && TextAt(json, "alg") != JwtAlgorithmName(key->algorithm())) {
    return Bad(field + ".alg",
               "found another algorithm, need " + std::string(JwtAlgorithmName(key->algorithm())));
  }
  if (json.contains("use") && TextAt(json, "use") != "sig") {
    return Bad(field + ".use", "found another use, need sig");
  }
  return key;
}

// The signature in the form that OpenSSL takes.
std::optional<std::string> ToDer(std::string_view signature) {
  if (signature.size() != 2 * kCoordinateBytes) return std::nullopt;
  const Signature pair(ECDSA_SIG_new());
  ECDSA_SIG_set0(pair.get(), NumberOf(signature.substr(0, kCoordinateBytes)).release(),
                 NumberOf(signature.substr(kCoordinateBytes)).release());
  unsigned char* der = nullptr;
  const int size = i2d_ECDSA_SIG(pair.get(), &der);
  if (size <= 0) return std::nullopt;
  std::string text(reinterpret_cast<char*>(der), static_cast<size_t>(size));
  OPENSSL_free(der);
  return text;
}

}  // namespace

bool JwtKey::Verifies(std::string_view message, std::string_view signature) const {
  std::optional<std::string> checked(signature);
  if (algorithm_ == JwtAlgorithm::kEs256) checked = ToDer(signature);
  const DigestContext context(EVP_MD_CTX_new());
  return checked && context &&
         EVP_DigestVerifyInit(context.get(), nullptr, EVP_sha256(), nullptr, key_.get()) == 1 &&
         EVP_DigestVerify(context.get(), Bytes(*checked), checked->size(), Bytes(message),
                          message.size()) == 1;
}

absl::StatusOr<JwtKeys> JwtKeys::Parse(std::string_view text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  const auto list = json.is_object() ? json.find("keys") : json.end();
  if (list == json.end() || !list->is_array() || list->empty() || list->size() > kMaxKeys) {
    return Bad("jwt-keys",
               absl::StrCat("found no key set, need JSON with 1 to ", kMaxKeys, " \"keys\""));
  }
  JwtKeys keys;
  for (size_t i = 0; i < list->size(); ++i) {
    const std::string field = absl::StrCat("jwt-keys.keys[", i, "]");
    const Json& entry = (*list)[i];
    const std::string id = entry.is_object() ? TextAt(entry, "kid") : std::string();
    if (id.empty()) return Bad(field + ".kid", "found none, need a name that tokens tell it by");
    auto key = ReadKey(entry, field);
    if (!key.ok()) return key.status();
    if (!keys.keys_.emplace(id, *std::move(key)).second) {
      return Bad(field + ".kid", "found one that another key has, need another");
    }
  }
  return keys;
}

const JwtKey* JwtKeys::Find(std::string_view key_id) const {
  const auto found = keys_.find(key_id);
  return found == keys_.end() ? nullptr : &found->second;
}

}  // namespace penumbra
