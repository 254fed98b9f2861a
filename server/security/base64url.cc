#include "server/security/base64url.h"

#include "absl/strings/escaping.h"

namespace penumbra {

std::optional<std::string> DecodeBase64Url(std::string_view text) {
  std::string bytes;
  // absl overlooks blanks and padding.
  if (!absl::WebSafeBase64Unescape({text.data(), text.size()}, &bytes)) return std::nullopt;
  if (absl::WebSafeBase64Escape(bytes) != text) return std::nullopt;
  return bytes;
}

}  // namespace penumbra
