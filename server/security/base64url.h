// Base64 with '-' and '_' and without padding (RFC 4648 §5, as RFC 7515 uses it), strictly.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace penumbra {

// Nothing for other characters, padding, blanks, or a last character with bits left over: each text
// of bytes has one spelling.
std::optional<std::string> DecodeBase64Url(std::string_view text);

}  // namespace penumbra
