#include "server/security/bearer_token.h"

#include <span>

#include "absl/strings/escaping.h"
#include "absl/strings/string_view.h"
#include "server/random_bytes.h"
#include "server/security/base64url.h"

namespace penumbra {
namespace {

constexpr std::string_view kPrefix = "penumbra_";
constexpr size_t kRandomBytes = 32;

}  // namespace

std::string MakeBearerToken() {
  return std::string(kPrefix) + absl::WebSafeBase64Escape(RandomBytes(kRandomBytes));
}

bool IsBearerToken(std::string_view text) {
  if (!text.starts_with(kPrefix)) return false;
  const auto bytes = DecodeBase64Url(text.substr(kPrefix.size()));
  return bytes && bytes->size() == kRandomBytes;
}

ContentHash HashOfToken(std::string_view token) { return Sha256(std::as_bytes(std::span(token))); }

}  // namespace penumbra
