#include "server/security/scene_scope.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr size_t kMaxPatterns = 64;
constexpr size_t kMaxPatternBytes = 128;  // as long as an id

bool IsPattern(std::string_view text) {
  return !text.empty() && text.size() <= kMaxPatternBytes &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return absl::ascii_isalnum(c) || c == '.' || c == '_' || c == '-' || c == '*';
         });
}

// Goes back to the last star only: at most |pattern| · |text| steps.
bool Matches(std::string_view pattern, std::string_view text) {
  size_t p = 0, t = 0;
  size_t after_star = std::string_view::npos, resume_at = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      after_star = ++p;
      resume_at = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (after_star != std::string_view::npos) {
      p = after_star;
      t = ++resume_at;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

}  // namespace

absl::StatusOr<SceneScope> SceneScope::Create(std::vector<std::string> patterns) {
  if (patterns.empty() || patterns.size() > kMaxPatterns) {
    return FieldError(
        absl::StatusCode::kInvalidArgument, "BAD_PATTERN", "scenes",
        absl::StrCat("found ", patterns.size(), " patterns, need 1 to ", kMaxPatterns));
  }
  for (const std::string& pattern : patterns) {
    if (!IsPattern(pattern)) {
      return FieldError(absl::StatusCode::kInvalidArgument, "BAD_PATTERN", "scenes",
                        absl::StrCat("found '", pattern.substr(0, kMaxPatternBytes),
                                     "', need 1 to 128 of the characters A-Z a-z 0-9 . _ - and *"));
    }
  }
  return SceneScope(std::move(patterns));
}

bool SceneScope::Contains(std::string_view scene_id) const {
  return std::any_of(patterns_.begin(), patterns_.end(),
                     [&](const std::string& pattern) { return Matches(pattern, scene_id); });
}

bool SceneScope::is_everything() const {
  return std::find(patterns_.begin(), patterns_.end(), "*") != patterns_.end();
}

}  // namespace penumbra
