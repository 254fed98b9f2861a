#include "server/storage/wal_check.h"

#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "server/storage/durable_file.h"

namespace penumbra {
namespace {

constexpr size_t kHeaderBytes = 32;
constexpr size_t kFrameHeaderBytes = 24;
constexpr uint32_t kMagic = 0x377f0682;  // the last bit: checksums of big-endian words

uint32_t BigEndian(std::span<const std::byte> bytes, size_t at) {
  uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return std::endian::native == std::endian::little ? __builtin_bswap32(word) : word;
}

class Checksum {
 public:
  explicit Checksum(bool words_are_big_endian) : big_endian_(words_are_big_endian) {}

  // Whole pairs of words.
  void Add(std::span<const std::byte> bytes) {
    for (size_t at = 0; at + 8 <= bytes.size(); at += 8) {
      first_ += Word(bytes, at) + second_;
      second_ += Word(bytes, at + 4) + first_;
    }
  }
  bool Equals(uint32_t first, uint32_t second) const {
    return first_ == first && second_ == second;
  }

 private:
  uint32_t Word(std::span<const std::byte> bytes, size_t at) const {
    const uint32_t word = BigEndian(bytes, at);
    return big_endian_ ? word : __builtin_bswap32(word);
  }

  const bool big_endian_;
  uint32_t first_ = 0;
  uint32_t second_ = 0;
};

// A frame: page number, size after a commit or 0, the header's two salts, checksum.
struct Frame {
  std::span<const std::byte> header;
  std::span<const std::byte> page;

  bool is_commit() const { return BigEndian(header, 4) != 0; }
  bool IsOf(std::span<const std::byte> log_header) const {
    return std::memcmp(header.data() + 8, log_header.data() + 16, 8) == 0;
  }
};

size_t PageBytes(std::span<const std::byte> log) {
  const uint32_t bytes = BigEndian(log, 8);
  return bytes >= 512 && bytes <= 65'536 && std::has_single_bit(bytes) ? bytes : 0;
}

}  // namespace

WalState CheckWal(std::span<const std::byte> log) {
  if (log.empty()) return WalState::kWhole;
  if (log.size() < kHeaderBytes) return WalState::kTornTail;
  const uint32_t magic = BigEndian(log, 0);
  const size_t page_bytes = PageBytes(log);
  Checksum checksum((magic & 1) != 0);
  checksum.Add(log.first(24));
  if ((magic & ~1u) != kMagic || page_bytes == 0 ||
      !checksum.Equals(BigEndian(log, 24), BigEndian(log, 28))) {
    // The header is synced before the first frame is written.
    return log.size() == kHeaderBytes ? WalState::kTornTail : WalState::kDamaged;
  }
  const size_t frame_bytes = kFrameHeaderBytes + page_bytes;
  bool is_readable = true;
  size_t frames_after_commit = 0;  // that can be read and await their commit
  size_t lost_frames = 0;
  size_t lost_commits = 0;
  for (size_t at = kHeaderBytes; at + frame_bytes <= log.size(); at += frame_bytes) {
    const Frame frame{log.subspan(at, kFrameHeaderBytes),
                      log.subspan(at + kFrameHeaderBytes, page_bytes)};
    const bool is_of_this_log = frame.IsOf(log);
    if (is_readable) {
      checksum.Add(frame.header.first(8));
      checksum.Add(frame.page);
      is_readable = is_of_this_log &&
                    checksum.Equals(BigEndian(frame.header, 16), BigEndian(frame.header, 20));
      if (is_readable) frames_after_commit = frame.is_commit() ? 0 : frames_after_commit + 1;
      if (is_readable) continue;
    }
    // Of an earlier log, whose place this one takes bit by bit.
    if (!is_of_this_log) continue;
    // What follows a commit that is lost is a later transaction.
    if (lost_commits > 0) return WalState::kDamaged;
    ++lost_frames;
    lost_commits += frame.is_commit();
  }
  const bool is_torn =
      lost_frames > 0 || frames_after_commit > 0 || (log.size() - kHeaderBytes) % frame_bytes != 0;
  return is_torn ? WalState::kTornTail : WalState::kWhole;
}

absl::StatusOr<WalState> CheckWalFile(const std::string& path) {
  const auto log = ReadFileIfThere(path);
  if (!log.ok()) return log.status();
  return CheckWal(std::as_bytes(std::span(*log)));
}

}  // namespace penumbra
