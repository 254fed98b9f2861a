#include "client/cli/option_error.h"

#include <string>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr size_t kMaxQuotedBytes = 64;

bool IsControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

}  // namespace

absl::Status OptionError(std::string_view option, std::string_view reason, FoundText found,
                         std::string_view rest) {
  std::string text = "found \"";
  for (const char c : found.text.substr(0, kMaxQuotedBytes)) text += IsControl(c) ? '?' : c;
  if (found.text.size() > kMaxQuotedBytes) text += "…";
  text += '"';
  text += rest;
  return FieldError(absl::StatusCode::kInvalidArgument, reason, option, text);
}

std::string OneLine(std::string_view text) {
  std::string line(text);
  for (char& c : line) {
    if (IsControl(c)) c = ' ';
  }
  return line;
}

}  // namespace penumbra
