// Errors about what was typed: `--size: found "0x0", need …`.
//
//   return OptionError("--size", "RANGE", {text}, ", need WIDTHxHEIGHT");
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"

namespace penumbra {

// Text from outside, shown in quotes, cut at 64 bytes and with control characters as '?', so that
// an error stays one readable line.
struct FoundText {
  std::string_view text;
};

// kInvalidArgument: `option: found "quoted"rest`.
absl::Status OptionError(std::string_view option, std::string_view reason, FoundText found,
                         std::string_view rest);

// kNotFound UNKNOWN_ID: `option: found "id", need one of: …`, with a dozen of the `known` ids at
// most. `where` is what has none, if there is none.
absl::Status UnknownIdError(std::string_view option, std::string_view id,
                            std::vector<std::string> known, std::string_view where = "the scene");

// An error of a field, as one of the option that the field's value came from.
absl::Status OfOption(std::string_view option, const absl::Status& error);

// `text` on one line: control characters become blanks.
std::string OneLine(std::string_view text);

}  // namespace penumbra
