#include "server/quota/quota_options.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <set>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr double kMostCount = 1e6;

absl::Status Wrong(const std::string& found, const std::string& need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "quota",
                    absl::StrCat("found '", found, "', need ", need));
}

// -1: none.
double NumberOf(std::string text) {
  double factor = 1;
  if (!text.empty()) {
    constexpr char kUnits[] = "KMG";
    for (int i = 0; i < 3; ++i) {
      if (text.back() == kUnits[i]) factor = std::pow(1024.0, i + 1);
    }
    if (factor > 1) text.pop_back();
  }
  double number = 0;
  const bool is_number = absl::SimpleAtod(text, &number) && std::isfinite(number) && number >= 0;
  return is_number ? number * factor : -1;
}

absl::Status Set(const std::string& what, double number, PrincipalQuota& quota) {
  const auto whole = static_cast<uint64_t>(number);
  const bool is_count = number <= kMostCount && static_cast<double>(whole) == number;
  if (what == "scenes" && is_count) {
    quota.scenes = static_cast<uint32_t>(whole);
  } else if (what == "sessions" && is_count) {
    quota.sessions = static_cast<uint32_t>(whole);
  } else if (what == "blob-bytes" && number < 1e18) {
    quota.blob_bytes = whole;
  } else if (what == "compute" && number <= kMostCount) {
    quota.compute_s_per_minute = number;
  } else if (what == "weight" && number > 0 && number <= kMostCount) {
    quota.weight = number;
  } else {
    return Wrong(absl::StrCat(what, "=", number),
                 "scenes, sessions, blob-bytes, compute or weight, and a number that fits");
  }
  return absl::OkStatus();
}

// A range lets pass what is no number. Empty: it is one.
std::string SayIfNotANumber(const std::string& text) {
  double number = 0;
  if (absl::SimpleAtod(text, &number) && !std::isnan(number)) return {};
  return absl::StrCat("found '", text, "', need a number");
}

}  // namespace

void AddQuotaOptions(CLI::App& app, QuotaSettings& settings) {
  const auto add = [&app](const char* name, auto& value, const char* help) {
    return app.add_option(name, value, help)->capture_default_str()->group("Quotas");
  };
  add("--quota-scenes", settings.each.scenes,
      "Scenes that a principal may have made; 0: any number")
      ->check(CLI::Range(0, 1'000'000));
  add("--quota-sessions", settings.each.sessions,
      "Sessions that a principal may have open at a time; 0: any number")
      ->check(CLI::Range(0, 1'000'000));
  add("--quota-blob-bytes", settings.each.blob_bytes,
      "Bytes of blobs that a principal may have stored, with K, M or G; 0: any number")
      ->transform(CLI::AsSizeValue(false));
  add("--quota-compute", settings.each.compute_s_per_minute,
      "Seconds of computing for a principal a minute, past which its jobs give way to those of "
      "others; 0: any number")
      ->check(CLI::Range(0.0, 1e6))
      ->check(SayIfNotANumber);
  app.add_option(
         "--quota", settings.named,
         "Of one principal: NAME:WHAT=NUMBER,… with scenes, sessions, blob-bytes, compute or "
         "weight; more after a ; or by giving it again")
      ->group("Quotas");
}

absl::StatusOr<std::pair<std::string, PrincipalQuota>> ParseNamedQuota(std::string_view text,
                                                                       const PrincipalQuota& each) {
  const std::string whole(text);
  const size_t colon = text.rfind(':');  // names of certificates have them too
  if (colon == std::string_view::npos || colon == 0 || colon + 1 == text.size()) {
    return Wrong(whole, "NAME:WHAT=NUMBER,…");
  }
  PrincipalQuota quota = each;
  std::set<std::string> given;
  const std::vector<std::string> parts = absl::StrSplit(whole.substr(colon + 1), ',');
  for (const std::string& part : parts) {
    const std::vector<std::string> pair = absl::StrSplit(part, '=');
    const double number = pair.size() == 2 ? NumberOf(pair[1]) : -1;
    if (number < 0) return Wrong(part, "WHAT=NUMBER");
    if (!given.insert(pair[0]).second) return Wrong(whole, "each number once");
    if (auto status = Set(pair[0], number, quota); !status.ok()) return status;
  }
  return std::pair(whole.substr(0, colon), quota);
}

absl::StatusOr<QuotaOptions> ToOptions(const QuotaSettings& settings, bool everyone_is_known) {
  QuotaOptions options;
  if (!(settings.each.compute_s_per_minute >= 0)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "quota-compute",
                      absl::StrCat("found '", settings.each.compute_s_per_minute,
                                   "', need a number of seconds, 0 or more"));
  }
  if (everyone_is_known) options.each = settings.each;
  for (const std::string& texts : settings.named) {
    // The environment gives all of them in one.
    const std::vector<std::string> each = absl::StrSplit(texts, ';');
    for (const std::string& text : each) {
      auto named = ParseNamedQuota(text, options.each);
      if (!named.ok()) return named.status();
      if (!options.named.insert(*std::move(named)).second) return Wrong(text, "each name once");
    }
  }
  return options;
}

}  // namespace penumbra
