#include "client/cli/numbers.h"

#include <charconv>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "client/cli/option_error.h"

namespace penumbra {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

std::string_view SkipBlanks(std::string_view text) {
  const size_t start = text.find_first_not_of(kBlanks);
  return start == std::string_view::npos ? std::string_view() : text.substr(start);
}

// The number that all of `word` spells, or NaN.
float NumberOf(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  float value = 0.0f;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool whole = error == std::errc() && end == word.data() + word.size();
  return whole && std::isfinite(value) ? value : std::nanf("");
}

// One side of a size, or 0.
uint32_t SideOf(std::string_view word) {
  uint32_t side = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), side);
  return error == std::errc() && end == word.data() + word.size() ? side : 0;
}

}  // namespace

absl::StatusOr<std::vector<float>> ParseNumbers(std::string_view option, std::string_view text) {
  std::vector<float> numbers;
  for (std::string_view rest = SkipBlanks(text); !rest.empty();) {
    const size_t length = std::min(rest.find_first_of(", \t\r\n"), rest.size());
    const std::string_view word = rest.substr(0, length);
    const float number = NumberOf(word);
    if (std::isnan(number)) {
      return OptionError(option, "NUMBER", {word},
                         absl::StrCat(" as number ", numbers.size() + 1, ", need a finite number"));
    }
    numbers.push_back(number);
    rest = SkipBlanks(rest.substr(length));
    if (rest.starts_with(',')) {
      rest = SkipBlanks(rest.substr(1));
      if (rest.empty()) return OptionError(option, "NUMBER", {","}, " at the end, need a number");
    }
  }
  return numbers;
}

bool IsNumbers(std::string_view text) {
  const auto numbers = ParseNumbers("", text);
  return numbers.ok() && !numbers->empty();
}

Vec3 Vec3At(std::span<const float> numbers, size_t offset) {
  return {numbers[offset], numbers[offset + 1], numbers[offset + 2]};
}

absl::StatusOr<GridSize> ParseSize(std::string_view option, std::string_view text,
                                   uint32_t max_side) {
  const std::string_view trimmed = SkipBlanks(text);
  const size_t split = trimmed.find_first_of("xX, \t");
  GridSize size;
  size.width = SideOf(trimmed.substr(0, split));
  size.height =
      split == std::string_view::npos ? size.width : SideOf(SkipBlanks(trimmed.substr(split + 1)));
  const bool in_range =
      size.width >= 1 && size.width <= max_side && size.height >= 1 && size.height <= max_side;
  if (in_range) return size;
  return OptionError(option, "RANGE", {text},
                     absl::StrCat(", need WIDTHxHEIGHT with sides from 1 to ", max_side));
}

}  // namespace penumbra
