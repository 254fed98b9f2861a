// Options of numbers, before the parser sees them.

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/command_line.h"
#include "client/cli/light_option.h"
#include "client/cli/numbers.h"

namespace penumbra {
namespace {

bool TakesNumbers(const std::string& argument) {
  static constexpr const char* kOthers[] = {"--receiver",   "--size",    "--texture-size",
                                            "--camera",     "--ambient", "--ambient-radiance",
                                            "--reflectance"};
  const auto is_argument = [&](const char* name) { return argument == name; };
  const auto is_light = [&](const LightOption& option) { return argument == option.name; };
  return std::ranges::any_of(kOthers, is_argument) || std::ranges::any_of(LightOptions(), is_light);
}

}  // namespace

std::vector<std::string> TieNumbersToOptions(const std::vector<std::string>& arguments) {
  std::vector<std::string> tied;
  for (size_t i = 0; i < arguments.size(); ++i) {
    tied.push_back(arguments[i]);
    if (!TakesNumbers(arguments[i])) continue;
    std::string numbers;
    while (i + 1 < arguments.size() && IsNumbers(arguments[i + 1])) {
      absl::StrAppend(&numbers, numbers.empty() ? "" : " ", arguments[++i]);
    }
    if (!numbers.empty()) absl::StrAppend(&tied.back(), "=", numbers);
  }
  return tied;
}

}  // namespace penumbra
