#include "tests/fuzz/targets/log_frames.h"

#include <algorithm>
#include <cstdint>
#include <string_view>

namespace penumbra::fuzzing {
namespace {

constexpr uint32_t kLittleEndianSums = 0x377f0682;  // the magic of a log with such checksums

size_t FrameAt(size_t index) { return kLogHeadBytes + index * kFrameBytes; }

uint32_t Word(std::string_view bytes, size_t at, bool big_endian) {
  uint32_t word = 0;
  for (size_t i = 0; i < 4; ++i) {
    const size_t shift = 8 * (big_endian ? 3 - i : i);
    word |= uint32_t{static_cast<uint8_t>(bytes[at + i])} << shift;
  }
  return word;
}

void PutBigEndian(uint32_t word, std::string& bytes, size_t at) {
  for (size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(word >> (8 * (3 - i)));
}

struct Sum {
  uint32_t first = 0, second = 0;

  void Add(std::string_view bytes) {
    for (size_t at = 0; at + 8 <= bytes.size(); at += 8) {
      first += Word(bytes, at, false) + second;
      second += Word(bytes, at + 4, false) + first;
    }
  }
  void PutAt(std::string& bytes, size_t at) const {
    PutBigEndian(first, bytes, at);
    PutBigEndian(second, bytes, at + 4);
  }
};

}  // namespace

size_t FrameCount(const std::string& log) {
  return log.size() < kLogHeadBytes ? 0 : (log.size() - kLogHeadBytes) / kFrameBytes;
}

void SwapFrames(std::string& log, size_t a, size_t b) {
  if (a == b) return;
  const auto first = log.begin() + static_cast<ptrdiff_t>(FrameAt(a));
  std::swap_ranges(first, first + static_cast<ptrdiff_t>(kFrameBytes),
                   log.begin() + static_cast<ptrdiff_t>(FrameAt(b)));
}

void DropFrame(std::string& log, size_t index) { log.erase(FrameAt(index), kFrameBytes); }

void CopyFrame(std::string& log, size_t from, size_t behind) {
  const std::string frame = log.substr(FrameAt(from), kFrameBytes);
  log.insert(FrameAt(behind + 1), frame);
}

void SumAnew(std::string& log) {
  if (log.size() < kLogHeadBytes) return;
  PutBigEndian(kLittleEndianSums, log, 0);
  Sum sum;
  sum.Add(std::string_view(log).substr(0, 24));
  sum.PutAt(log, 24);
  for (size_t i = 0; i < FrameCount(log); ++i) {
    const size_t at = FrameAt(i);
    std::copy_n(log.begin() + 16, 8, log.begin() + static_cast<ptrdiff_t>(at + 8));
    sum.Add(std::string_view(log).substr(at, 8));
    sum.Add(std::string_view(log).substr(at + kFrameHeadBytes, kFrameBytes - kFrameHeadBytes));
    sum.PutAt(log, at + 16);
  }
}

}  // namespace penumbra::fuzzing
