// The options of the command line that say what principals may use.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/quota/principal_quotas.h"

namespace CLI {
class App;
}

namespace penumbra {

// As they are given.
struct QuotaSettings {
  PrincipalQuota each{};
  std::vector<std::string> named;  // NAME:WHAT=NUMBER,… one or more, with ; between
};

// `settings` must outlive the parsing.
void AddQuotaOptions(CLI::App& app, QuotaSettings& settings);

// The name, and `each` with what the text changes of it: "ana:scenes=20,compute=30" for instance.
// Numbers may end in K, M or G, which are powers of 1,024.
//
// Errors  kInvalidArgument, field "quota": what is wrong with the text
absl::StatusOr<std::pair<std::string, PrincipalQuota>> ParseNamedQuota(std::string_view text,
                                                                       const PrincipalQuota& each);

// `everyone_is_known`: callers show who they are. Where they do not, all of them are one principal,
// which has no quotas but those that its name is given.
//
// Errors  those of ParseNamedQuota; a name twice; field "quota-compute": no number
absl::StatusOr<QuotaOptions> ToOptions(const QuotaSettings& settings, bool everyone_is_known);

}  // namespace penumbra
