// How a file holds the records of an archive, format 1:
//
//   "PENUMBRA ARCHIVE 1\n"
//   for each record:  u32 size, little-endian     1 to 2^22
//                     size bytes                  v1.ArchiveRecord
//                     32 bytes                    its seal
//
// A seal is the SHA-256 of the seal before it, the size and the bytes; before the first record
// stands the SHA-256 of the first line. So the last seal, the end's, is over the whole file, and
// the first that does not fit says where it was changed. After the end's there is nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "render/scene/content_hash.h"
#include "render/scene/hashed_text.h"

namespace penumbra {

inline constexpr std::string_view kArchiveName = "PENUMBRA ARCHIVE ";
inline constexpr std::string_view kArchiveFirstLine = "PENUMBRA ARCHIVE 1\n";
inline constexpr size_t kMaxRecordBytes = size_t{1} << 22;
inline constexpr size_t kSizeBytes = 4;
inline constexpr size_t kSealBytes = 32;

inline std::string SizeText(uint32_t size) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>(size >> shift);
  return text;
}

inline uint32_t SizeIn(std::string_view text) {
  uint32_t size = 0;
  for (size_t i = 0; i < kSizeBytes; ++i) {
    size |= static_cast<uint32_t>(static_cast<unsigned char>(text[i])) << (8 * i);
  }
  return size;
}

inline ContentHash FirstSeal() { return HashOfBytes(kArchiveFirstLine); }

// `framed`  a record's size and its bytes
inline ContentHash NextSeal(const ContentHash& seal, std::string_view framed) {
  return HashOfBytes(std::string(BytesOf(seal)).append(framed));
}

}  // namespace penumbra
