// Numbers as people type them: separated by commas or blanks, "0 2.5,-1" as well as "0,2.5,-1".
//
//   auto numbers = ParseNumbers("--receiver", "-1 0 1  2 0 0  0 0 -2");
//   if (!numbers.ok()) …   // "--receiver: found "x" as number 3, need a finite number"
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <vector>

#include "absl/status/statusor.h"
#include "render/math/vec.h"

namespace penumbra {

// Errors  kInvalidArgument, reason NUMBER; the field path is `option`.
absl::StatusOr<std::vector<float>> ParseNumbers(std::string_view option, std::string_view text);

// The whole number that `text` is, and nothing else.
template <typename Integer>
std::optional<Integer> ReadInteger(std::string_view text) {
  Integer value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Whether `text` is nothing but numbers and what separates them.
bool IsNumbers(std::string_view text);

// The three numbers from `offset` on.
Vec3 Vec3At(std::span<const float> numbers, size_t offset);

struct GridSize {
  uint32_t width = 256;
  uint32_t height = 256;

  friend bool operator==(const GridSize&, const GridSize&) = default;
};

// "256x128", "256 128", "256,128", or "256" for a square. Each side is 1 to `max_side`.
//
// Errors  kInvalidArgument, reason RANGE; the field path is `option`.
absl::StatusOr<GridSize> ParseSize(std::string_view option, std::string_view text,
                                   uint32_t max_side);

}  // namespace penumbra
