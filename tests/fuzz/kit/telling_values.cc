#include "tests/fuzz/kit/telling_values.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string_view>

#include "tests/fuzz/kit/mutation.h"

namespace penumbra::fuzzing {
namespace {

constexpr uint64_t kIntegers[] = {0,
                                  1,
                                  2,
                                  3,
                                  7,
                                  8,
                                  63,
                                  64,
                                  65,
                                  127,
                                  128,
                                  255,
                                  256,
                                  1'024,
                                  1'025,
                                  4'096,
                                  8'192,
                                  16'384,
                                  16'385,
                                  65'535,
                                  65'536,
                                  1u << 26,
                                  0x7fffffff,
                                  0x80000000,
                                  0xffffffff,
                                  uint64_t{1} << 32,
                                  uint64_t{1} << 53,
                                  std::numeric_limits<int64_t>::max(),
                                  uint64_t{1} << 63,
                                  std::numeric_limits<uint64_t>::max()};

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kReals[] = {std::numeric_limits<double>::quiet_NaN(),
                             kInfinity,
                             -kInfinity,
                             0.0,
                             -0.0,
                             std::numeric_limits<float>::denorm_min(),
                             -std::numeric_limits<float>::denorm_min(),
                             std::numeric_limits<double>::denorm_min(),
                             std::numeric_limits<float>::min(),
                             1e-30,
                             1e-20,
                             1e-7,
                             0.25,
                             0.5,
                             1,
                             -1,
                             2,
                             1.5707963267948966,
                             3.141592653589793,
                             180,
                             255,
                             1e9,
                             1.0001e9,
                             -1e9,
                             1e15,
                             1e19,
                             1e30,
                             std::numeric_limits<float>::max(),
                             -std::numeric_limits<float>::max(),
                             1e300};

constexpr std::string_view kTexts[] = {"",
                                       "a",
                                       "b",
                                       "*",
                                       "studio",
                                       "lamp",
                                       "floor",
                                       "box",
                                       "../../etc/passwd",
                                       "a/b",
                                       "a b",
                                       "one\r\ntwo",
                                       std::string_view("nul\0nul", 7),
                                       "\x1b[2Jred",
                                       "\xe2\x80\xaegnp.exe",    // right-to-left override
                                       "zero\xe2\x80\x8bwidth",  // zero-width space
                                       "\xcc\x81",               // a combining accent alone
                                       "%s%n{}",
                                       "\"'\\",
                                       "<script>",
                                       "sha256:",
                                       "18446744073709551616"};

// Numbers of single precision where planes of them are.
void PutReal(Draws& draws, std::string& bytes) {
  if (bytes.size() < sizeof(float)) return;
  const size_t at = draws.Below(bytes.size() / sizeof(float)) * sizeof(float);
  float number;
  std::memcpy(&number, &bytes[at], sizeof(number));
  number = TellingReal(draws, number);
  std::memcpy(&bytes[at], &number, sizeof(number));
}

}  // namespace

uint64_t TellingInteger(Draws& draws, uint64_t now) {
  switch (draws.Below(5)) {
    case 0:
      return now + draws.Below(33) - 16;
    case 1:
      return draws.Below(20);
    case 2:
      return draws.Below(300);
    case 3:
      return now ^ uint64_t { 1 } << draws.Below(64);
    default:
      return draws.OneOf(kIntegers);
  }
}

double TellingReal(Draws& draws, double now) {
  switch (draws.Below(6)) {
    case 0:
      return -now;
    case 1:
      return now * (draws.OneIn(2) ? 2 : 0.5);
    case 2:
      return now + 0.01 * (static_cast<double>(draws.Below(201)) - 100);
    case 3:
      return 0.01 * (static_cast<double>(draws.Below(2'001)) - 1'000);
    case 4:
      return now * (1 + 1e-7 * static_cast<double>(draws.Below(9)));
    default:
      return draws.OneOf(kReals);
  }
}

float TellingReal(Draws& draws, float now) {
  constexpr double kMost = std::numeric_limits<float>::max();
  const double telling = TellingReal(draws, double{now});
  if (telling > kMost) return std::numeric_limits<float>::infinity();
  if (telling < -kMost) return -std::numeric_limits<float>::infinity();
  return static_cast<float>(telling);
}

std::string TellingText(Draws& draws, const std::string& now, std::span<const std::string> words) {
  const bool is_ascii =
      std::ranges::all_of(now, [](char c) { return static_cast<int8_t>(c) >= 0; });
  switch (draws.Below(5)) {
    case 0:
    case 1:
      if (!words.empty()) return draws.OneOf(words);
      [[fallthrough]];
    case 2:
      return std::string(draws.OneOf(kTexts));
    case 3:
      return std::string(draws.OneIn(2) ? 128 + draws.Below(3) : draws.Below(1'100), 'x');
    default:
      break;
  }
  std::string text = is_ascii ? now : "";
  const size_t at = draws.Below(text.size() + 1);
  if (at < text.size() && draws.OneIn(2)) return text.erase(at, 1 + draws.Below(4));
  return text.insert(at, 1, static_cast<char>(' ' + draws.Below(95)));
}

std::string TellingBytes(Draws& draws, const std::string& now, std::span<const std::string> words) {
  constexpr size_t kLengths[] = {0, 1, 4, 12, 15, 16, 17, 24, 31, 32, 33, 64};
  std::string bytes = now;
  switch (draws.Below(6)) {
    case 0:
      if (!words.empty()) return draws.OneOf(words);
      break;
    case 1:
      bytes.resize(draws.OneOf(kLengths), static_cast<char>(draws.Bits()));
      return bytes;
    case 2:
    case 3:
      PutReal(draws, bytes);
      return bytes;
    case 4:
      if (!bytes.empty()) bytes[draws.Below(bytes.size())] = static_cast<char>(draws.Bits());
      return bytes;
    default:
      break;
  }
  return Mutated(bytes, draws.Bits());
}

}  // namespace penumbra::fuzzing
