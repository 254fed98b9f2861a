#include "tests/fuzz/kit/mutation.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "render/math/random.h"

namespace penumbra {
namespace {

// Numbers on whose sides code takes different ways.
constexpr std::array<uint32_t, 10> kWords = {
    0, 1, 0x7f, 0xff, 0xffff, 0x7fffffff, 0x80000000, 0xffffffff, 0x7f800000, 0x7fc00000};
constexpr std::array<std::string_view, 14> kNumbers = {
    "0",          "-1",         "1",
    "2",          "255",        "65536",
    "2147483647", "4294967295", "18446744073709551615",
    "1e300",      "-1e-300",    "0.5",
    "1e38",       "999999999"};

class Mutator {
 public:
  Mutator(std::string bytes, uint64_t seed) : bytes_(std::move(bytes)), seed_(seed) {}

  std::string Run() {
    const uint64_t count = 1 + Below(4);
    for (uint64_t i = 0; i < count && !bytes_.empty(); ++i) Step();
    return std::move(bytes_);
  }

 private:
  uint64_t Below(uint64_t n) {
    return static_cast<uint64_t>(UniformAt(seed_, draws_++, 0) * static_cast<double>(n));
  }

  void Step() {
    const size_t at = Below(bytes_.size());
    const size_t length = 1 + Below(std::min<size_t>(bytes_.size() - at, 64));
    switch (Below(8)) {
      case 0:
        bytes_[at] = static_cast<char>(bytes_[at] ^ (1 << Below(8)));
        break;
      case 1:
        bytes_[at] = static_cast<char>(kWords[Below(kWords.size())]);
        break;
      case 2: {
        const uint32_t word = kWords[Below(kWords.size())];
        if (at + sizeof(word) <= bytes_.size()) std::memcpy(&bytes_[at], &word, sizeof(word));
        break;
      }
      case 3:
        bytes_.erase(at, length);
        break;
      case 4:
        bytes_.insert(at, bytes_.substr(at, length));
        break;
      case 5:
        bytes_.insert(Below(bytes_.size()), bytes_.substr(at, length));
        break;
      case 6:
        ReplaceNumber();
        break;
      case 7:
        if (Below(4) == 0) bytes_.resize(at);
        break;
    }
  }

  void ReplaceNumber() {
    constexpr std::string_view kDigits = "0123456789.";
    const size_t start = bytes_.find_first_of(kDigits, Below(bytes_.size()));
    if (start == std::string::npos) return;
    const size_t end = std::min(bytes_.find_first_not_of(kDigits, start), bytes_.size());
    bytes_.replace(start, end - start, kNumbers[Below(kNumbers.size())]);
  }

  std::string bytes_;
  uint64_t seed_;
  uint64_t draws_ = 0;
};

}  // namespace

std::string Mutated(const std::string& bytes, uint64_t seed) { return Mutator(bytes, seed).Run(); }

}  // namespace penumbra
