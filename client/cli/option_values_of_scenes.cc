// Values of options that name servers, scenes and how often.

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "client/cli/numbers.h"
#include "client/cli/option_error.h"
#include "client/cli/option_values.h"
#include "render/scene/scene.h"

namespace penumbra {
namespace {

absl::Status RangeError(std::string_view option, std::string_view text, const std::string& need) {
  return OptionError(option, "RANGE", {text}, absl::StrCat(", need ", need));
}

// gRPC takes a port modulo 65,536, and what is no number for 0. An IPv6 address without a port ends
// with its bracket.
bool NamesPlace(std::string_view address) {
  for (const std::string_view scheme : {"unix:", "unix-abstract:"}) {
    if (address.starts_with(scheme)) return address.size() > scheme.size();
  }
  const size_t colon = address.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  const auto port = ReadInteger<uint32_t>(address.substr(colon + 1));
  return port && *port >= 1 && *port <= 65'535;
}

}  // namespace

absl::Status SetServer(std::string_view text, std::string& server) {
  if (!NamesPlace(text)) {
    return OptionError("--server", "BAD_ADDRESS", {text},
                       ", need HOST:PORT with a port from 1 to 65535, or unix:PATH");
  }
  server = text;
  return absl::OkStatus();
}

absl::Status SetSceneId(std::string_view option, std::string_view text, std::string& scene_id) {
  scene_id = text;
  return CheckId(text, option);
}

absl::Status SetCount(std::string_view option, std::string_view text, uint32_t& count) {
  const auto number = ReadInteger<uint32_t>(text);
  if (!number) return RangeError(option, text, "a whole number");
  count = *number;
  return absl::OkStatus();
}

absl::Status SetRevision(std::string_view option, std::string_view text,
                         std::optional<uint64_t>& revision) {
  revision = ReadInteger<uint64_t>(text);
  return revision ? absl::OkStatus() : RangeError(option, text, "a revision, a whole number");
}

absl::Status SetWithin(std::string_view option, std::string_view text, double least, double most,
                       double& value) {
  const bool is_number = absl::SimpleAtod(std::string(text), &value);
  if (is_number && value >= least && value <= most) return absl::OkStatus();
  return RangeError(option, text, absl::StrCat("a number from ", least, " to ", most));
}

}  // namespace penumbra
