// Which scenes someone may know of, by patterns of their ids.
//
//   auto scope = SceneScope::Create({"review-*", "studio"});
//   scope->Contains("review-7");  // true
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace penumbra {

class SceneScope {
 public:
  static SceneScope Everything() { return SceneScope({"*"}); }

  // `*` in a pattern stands for any run of characters, none included.
  //
  // Errors  kInvalidArgument BAD_PATTERN, field "scenes": no pattern, more than 64, or one that is
  //         not 1 to 128 characters of [A-Za-z0-9._*-]
  static absl::StatusOr<SceneScope> Create(std::vector<std::string> patterns);

  bool Contains(std::string_view scene_id) const;
  bool is_everything() const;
  const std::vector<std::string>& patterns() const { return patterns_; }

  friend bool operator==(const SceneScope&, const SceneScope&) = default;

 private:
  explicit SceneScope(std::vector<std::string> patterns) : patterns_(std::move(patterns)) {}

  std::vector<std::string> patterns_;
};

}  // namespace penumbra
