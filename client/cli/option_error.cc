#include "client/cli/option_error.h"

#include <string>
#include <vector>

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr size_t kMaxQuotedBytes = 64;

// Enough of a list to find a spelling mistake by, still one line.
constexpr size_t kMaxIds = 12;

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

absl::Status UnknownIdError(std::string_view option, std::string_view id,
                            std::vector<std::string> known, std::string_view where) {
  const bool is_cut = known.size() > kMaxIds;
  if (is_cut) known.resize(kMaxIds);
  const std::string need =
      known.empty()
          ? absl::StrCat(", but ", std::string(where), " has none")
          : absl::StrCat(", need one of: ", absl::StrJoin(known, ", "), is_cut ? ", …" : "");
  const absl::Status wrong = OptionError(option, "UNKNOWN_ID", {id}, need);
  absl::Status missing = absl::NotFoundError(wrong.message());
  wrong.ForEachPayload([&](absl::string_view name, const absl::Cord& payload) {
    missing.SetPayload(name, payload);
  });
  return missing;
}

absl::Status OfOption(std::string_view option, const absl::Status& error) {
  std::string_view found(error.message().data(), error.message().size());
  const std::string field = ErrorFieldPath(error) + ": ";
  if (found.starts_with(field)) found.remove_prefix(field.size());
  return FieldError(error.code(), ErrorReason(error), option, found);
}

std::string OneLine(std::string_view text) {
  std::string line(text);
  for (char& c : line) {
    if (IsControl(c)) c = ' ';
  }
  return line;
}

}  // namespace penumbra
