#include "render/scene/field_error.h"

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace penumbra {
namespace {

constexpr char kFieldPayload[] = "penumbra/field";
constexpr char kReasonPayload[] = "penumbra/reason";

absl::string_view View(std::string_view text) { return {text.data(), text.size()}; }

// A message may quote what a client sent, which may be as long as a request; an answer that quotes
// it twice would not fit into one. What is too much is left out of the middle.
constexpr size_t kMaxTextBytes = 1'024;
constexpr size_t kEndBytes = 192;

bool ContinuesCharacter(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

std::string Shortened(std::string_view text) {
  if (text.size() <= kMaxTextBytes) return std::string(text);
  size_t first = kMaxTextBytes - kEndBytes, last = text.size() - kEndBytes;
  while (first > 0 && ContinuesCharacter(text[first])) --first;
  while (last < text.size() && ContinuesCharacter(text[last])) ++last;
  return absl::StrCat(View(text.substr(0, first)), " ... ", View(text.substr(last)));
}

std::string Payload(const absl::Status& status, const char* name) {
  const auto payload = status.GetPayload(name);
  return payload ? std::string(*payload) : std::string();
}

}  // namespace

absl::Status FieldError(absl::StatusCode code, std::string_view reason, std::string_view field_path,
                        std::string_view found_and_need) {
  const std::string text = Shortened(found_and_need);
  absl::Status status(code, field_path.empty() ? text : absl::StrCat(View(field_path), ": ", text));
  if (!field_path.empty()) status.SetPayload(kFieldPayload, absl::Cord(View(field_path)));
  status.SetPayload(kReasonPayload, absl::Cord(View(reason)));
  return status;
}

std::string ErrorFieldPath(const absl::Status& status) { return Payload(status, kFieldPayload); }

std::string ErrorReason(const absl::Status& status) { return Payload(status, kReasonPayload); }

absl::Status WithFieldPrefix(const absl::Status& status, std::string_view prefix) {
  if (status.ok()) return status;
  const std::string field = ErrorFieldPath(status);
  absl::Status prefixed(status.code(), field.empty()
                                           ? absl::StrCat(View(prefix), ": ", status.message())
                                           : absl::StrCat(View(prefix), status.message()));
  status.ForEachPayload(
      [&](absl::string_view name, const absl::Cord& value) { prefixed.SetPayload(name, value); });
  prefixed.SetPayload(kFieldPayload, absl::Cord(absl::StrCat(View(prefix), field)));
  return prefixed;
}

absl::Status WithoutFieldPrefix(const absl::Status& status, std::string_view prefix) {
  const std::string field = ErrorFieldPath(status);
  if (!field.starts_with(prefix) || !std::string(status.message()).starts_with(prefix)) {
    return status;
  }
  absl::Status bare(status.code(), status.message().substr(prefix.size()));
  status.ForEachPayload(
      [&](absl::string_view name, const absl::Cord& value) { bare.SetPayload(name, value); });
  bare.SetPayload(kFieldPayload, absl::Cord(field.substr(prefix.size())));
  return bare;
}

}  // namespace penumbra
