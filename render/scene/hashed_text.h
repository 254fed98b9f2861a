// Texts of several fields, hashed so that no two lists of fields give one text.
//
//   const ContentHash hash = HashedText().Add(scene_id).Add(revision).Hash();
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "render/scene/content_hash.h"

namespace penumbra {

inline ContentHash HashOfBytes(std::string_view bytes) {
  return Sha256(std::as_bytes(std::span(bytes)));
}

inline std::string_view BytesOf(const ContentHash& hash) {
  return {reinterpret_cast<const char*>(hash.bytes.data()), hash.bytes.size()};
}

// Fields one after another, each with its length before it. Numbers are 8 bytes, the least first.
class HashedText {
 public:
  HashedText& Add(std::string_view bytes) {
    Add(bytes.size());
    text_.append(bytes);
    return *this;
  }
  HashedText& Add(uint64_t number) {
    for (int shift = 0; shift < 64; shift += 8) text_ += static_cast<char>(number >> shift);
    return *this;
  }
  HashedText& Add(const ContentHash& hash) { return Add(BytesOf(hash)); }
  ContentHash Hash() const { return HashOfBytes(text_); }

 private:
  std::string text_;
};

}  // namespace penumbra
