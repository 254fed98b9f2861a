// The bytes by which a value counts in a hash, field by field. −0 is written as 0.
//
//   HashedBytes bytes;
//   bytes.Put(light.id);
//   ContentHash hash = bytes.Hash();
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "render/math/vec.h"
#include "render/scene/content_hash.h"

namespace penumbra {

class HashedBytes {
 public:
  void Put(const std::string& text) {
    Put(static_cast<uint32_t>(text.size()));
    Append(text.data(), text.size());
  }
  void Put(const ContentHash& hash) { Append(hash.bytes.data(), hash.bytes.size()); }
  void Put(float x) {
    x += 0.0f;
    Append(&x, sizeof(x));
  }
  void Put(Vec3 v) {
    for (int c = 0; c < 3; ++c) Put(v[c]);
  }
  void Put(uint32_t x) { Append(&x, sizeof(x)); }
  void Put(bool x) { Put(uint32_t{x}); }

  ContentHash Hash() const { return Sha256(std::as_bytes(std::span(bytes_))); }

 private:
  void Append(const void* data, size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }

  std::string bytes_;
};

}  // namespace penumbra
