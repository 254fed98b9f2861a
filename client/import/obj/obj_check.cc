#include "client/import/obj/obj_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/import/source_file.h"
#include "render/scene/field_error.h"

namespace penumbra::obj {
namespace {

// A polygon of more corners is no model's; cutting it up takes quadratic time.
constexpr size_t kMaxCorners = 4096;

// Cuts the first line off `rest`. As in tinyobjloader it ends in \n, \r\n or \r.
std::string_view TakeLine(std::string_view& rest) {
  const size_t length = rest.find_first_of("\r\n");
  const std::string_view line = rest.substr(0, length);
  if (length == std::string_view::npos) {
    rest = {};
  } else {
    rest.remove_prefix(length + (rest.substr(length).starts_with("\r\n") ? 2 : 1));
  }
  return line;
}

// The next word of `rest`, which is cut off it; empty at its end.
std::string_view TakeWord(std::string_view& rest) {
  constexpr std::string_view kBlanks = " \t";
  const size_t start = rest.find_first_not_of(kBlanks);
  rest.remove_prefix(start == std::string_view::npos ? rest.size() : start);
  const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
  rest.remove_prefix(word.size());
  return word;
}

// Which absl reads, and tinyobjloader takes for 0.
bool IsHexadecimal(std::string_view word) {
  return word.find_first_of("xX") != std::string_view::npos;
}

class Checker {
 public:
  explicit Checker(const SceneLimits& limits) : limits_(limits) {}

  absl::Status Check(std::string_view text) {
    while (!text.empty()) {
      ++line_;
      absl::Status status = Statement(TakeLine(text));
      if (!status.ok()) return status;
    }
    return absl::OkStatus();
  }

 private:
  // What has numbers: `kinds_[i]` is what the i-th part of a corner "v/vt/vn" points to.
  struct Kind {
    const char* keyword;
    int fewest;
    int most;  // that are read; more may follow
    const char* need;
    uint64_t count = 0;  // so far
  };

  absl::Status Statement(std::string_view rest);
  absl::Status Numbers(const Kind& kind, std::string_view rest) const;
  absl::Status Tag(std::string_view rest) const;
  absl::Status Face(std::string_view rest) const;
  absl::Status Corner(std::string_view word) const;
  absl::Status Index(const Kind& kind, std::string_view index, std::string_view corner) const;

  absl::Status Refused(const char* reason, const char* keyword, const std::string& found,
                       const std::string& need) const {
    return Malformed(reason, absl::StrCat("line ", line_, ": ", keyword),
                     absl::StrCat("found ", found, ", need ", need));
  }

  const SceneLimits& limits_;
  uint64_t line_ = 0;
  std::array<Kind, 3> kinds_ = {Kind{"v", 3, 3, "three finite numbers"},
                                Kind{"vt", 1, 2, "one or two finite numbers"},
                                Kind{"vn", 3, 3, "three finite numbers"}};
};

absl::Status Checker::Statement(std::string_view rest) {
  const std::string_view keyword = TakeWord(rest);
  if (keyword == "f") return Face(rest);
  if (keyword == "t") return Tag(rest);
  for (Kind& kind : kinds_) {
    if (keyword != kind.keyword) continue;
    ++kind.count;
    return Numbers(kind, rest);
  }
  return absl::OkStatus();
}

absl::Status Checker::Numbers(const Kind& kind, std::string_view rest) const {
  for (int i = 0; i < kind.most; ++i) {
    const std::string_view word = TakeWord(rest);
    // What follows a "#" is a comment.
    if (word.empty() || word.starts_with('#')) {
      if (i >= kind.fewest) break;
      return Refused("MALFORMED", kind.keyword, absl::StrCat(i, " numbers"), kind.need);
    }
    double number = 0.0;
    if (IsHexadecimal(word) || !absl::SimpleAtod({word.data(), word.size()}, &number)) {
      return Refused("MALFORMED", kind.keyword, Quoted(word), kind.need);
    }
    // Digits that overflow are infinite too.
    if (!std::isfinite(number)) {
      return Refused("NON_FINITE", kind.keyword, Quoted(word), kind.need);
    }
    if (std::abs(number) > limits_.max_coordinate) {
      return Refused("OUT_OF_BOUNDS", kind.keyword, Quoted(word),
                     absl::StrCat("at most ", limits_.max_coordinate, " in size"));
    }
  }
  return absl::OkStatus();
}

// "t crease 2/1/0 4 5 3.5": a name, how many integers, reals and strings follow, and they. The
// shadows need none of it, but tinyobjloader makes room for as many as the line says.
absl::Status Checker::Tag(std::string_view rest) const {
  TakeWord(rest);
  const std::string_view counts = TakeWord(rest);
  int64_t promised = 0;
  for (const absl::string_view count :
       absl::StrSplit(absl::string_view(counts.data(), counts.size()), '/')) {
    int64_t number = 0;
    if (!count.empty() && !absl::SimpleAtoi(count, &number)) {
      return Refused("MALFORMED", "t", Quoted(counts), "numbers of integers, reals and strings");
    }
    promised += std::clamp(number, int64_t{0}, int64_t{1} << 32);
  }
  int64_t follow = 0;
  while (!TakeWord(rest).empty()) ++follow;
  if (promised <= follow) return absl::OkStatus();
  return Refused("MALFORMED", "t", absl::StrCat(follow, " values after ", Quoted(counts)),
                 absl::StrCat(promised));
}

absl::Status Checker::Face(std::string_view rest) const {
  size_t corners = 0;
  for (std::string_view word = TakeWord(rest); !word.empty(); word = TakeWord(rest)) {
    if (++corners >= kMaxCorners) {
      return FieldError(
          absl::StatusCode::kResourceExhausted, "TOO_LARGE", absl::StrCat("line ", line_, ": f"),
          absl::StrCat("found a face of ", corners, " or more corners, need < ", kMaxCorners));
    }
    absl::Status status = Corner(word);
    if (!status.ok()) return status;
  }
  if (corners < 3) {
    return Refused("MALFORMED", "f", absl::StrCat(corners, " corners"), "at least 3");
  }
  return absl::OkStatus();
}

// "v", "v/vt", "v//vn" or "v/vt/vn".
absl::Status Checker::Corner(std::string_view word) const {
  std::string_view rest = word;
  for (size_t i = 0; i < kinds_.size(); ++i) {
    const size_t slash = rest.find('/');
    const std::string_view index = rest.substr(0, slash);
    const bool left_out = i == 1 && index.empty() && slash != std::string_view::npos;
    if (!left_out) {
      absl::Status status = Index(kinds_[i], index, word);
      if (!status.ok()) return status;
    }
    if (slash == std::string_view::npos) return absl::OkStatus();
    rest.remove_prefix(slash + 1);
  }
  return Refused("MALFORMED", "f", Quoted(word), "v, v/vt, v//vn or v/vt/vn");
}

absl::Status Checker::Index(const Kind& kind, std::string_view index,
                            std::string_view corner) const {
  if (index.empty() || index.find_first_not_of("+-0123456789") != std::string_view::npos) {
    return Refused("MALFORMED", "f", Quoted(corner), "v, v/vt, v//vn or v/vt/vn");
  }
  const auto count = static_cast<int64_t>(kind.count);
  int64_t number = 0;
  if (!absl::SimpleAtoi({index.data(), index.size()}, &number) || number == 0 || number > count ||
      number < -count) {
    return Refused("INDEX_RANGE", "f", Quoted(corner),
                   absl::StrCat("one of the ", count, " ", kind.keyword,
                                " so far, counted from 1, or back from -1"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckObj(std::string_view text, const SceneLimits& limits) {
  return Checker(limits).Check(text);
}

}  // namespace penumbra::obj
